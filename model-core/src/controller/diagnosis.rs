//! The self test: after a start, and under a latched fault.

use super::{Controller, Inputs};
use crate::actuation::Actuation;
use crate::observer::Observer;
use crate::self_test::{SelfTest, Verdict};
use crate::supervisor::Activity;
use crate::supervisor::fault::Fault;
use crate::units::Bend;

/// For so many ticks a finger that a fault has vented stays so before the diagnosis closes a valve.
const DIAGNOSIS_TICKS: u16 = 1000;
/// The same where the bend sensor cannot witness that it is empty: three chambers of twice the nominal volume behind valves of
/// 0.7 of the nominal conductance vent in 5 s, and half as much again.
const BLIND_DIAGNOSIS_TICKS: u16 = 7500;
/// A finger bent less than this in sum is empty: one chamber alone then has 4 kPa.
const STRAIGHT: Bend = Bend::from_deg(15);

/// The self test's phases under a latched fault.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is no heap to put it on, and one controller")]
pub(super) enum Diagnosis {
    /// Vented by the fault for so many ticks: not yet.
    Venting(u16),
    Runs(SelfTest),
    Done,
}

impl Controller {
    /// Looks for the part that failed, once for each latched fault: the finger vents, and the self test's phases name what
    /// does not respond. Nothing when that is not, or no longer, allowed.
    pub(super) fn diagnose(&mut self, inputs: &Inputs) -> Option<Actuation> {
        if !self.supervisor.may_diagnose() || self.self_test.is_some() {
            self.diagnosis = Diagnosis::Done;
            return None;
        }
        if let Diagnosis::Venting(ticks) = self.diagnosis {
            if ticks < DIAGNOSIS_TICKS || !self.is_straight(inputs) && ticks < BLIND_DIAGNOSIS_TICKS {
                self.diagnosis = Diagnosis::Venting(ticks.saturating_add(1));
                return None;
            }
            self.diagnosis = Diagnosis::Runs(SelfTest::new());
        }
        let Diagnosis::Runs(test) = &mut self.diagnosis else { return None };
        match test.step(inputs) {
            Verdict::Testing(actuation) => {
                if actuation != Actuation::SAFE {
                    self.activity = Activity::Testing;
                }
                return Some(actuation);
            }
            Verdict::Passed => {}
            Verdict::Failed(part) => {
                let named = test.named(part);
                self.supervisor.latch(named);
            }
        }
        self.diagnosis = Diagnosis::Done;
        None
    }

    /// The bend sensor works and says that the finger is straight: no chamber holds more than some kPa. That is another
    /// witness than the pressure sensor, which may be what failed.
    fn is_straight(&self, inputs: &Inputs) -> bool {
        let works = !self.supervisor.faults().contains(Fault::BendSensorFailed);
        let straight = |bend: Bend| (bend - self.bend_zero).abs() <= STRAIGHT;
        works && inputs.bend.valid().is_some_and(straight)
    }

    /// The self test's tick, while there is one: a failure is latched as a fault, and whatever fault there is starts the
    /// test over once it is cleared.
    pub(super) fn test(&mut self, inputs: &Inputs, fault: Option<Fault>) -> (Option<Fault>, Option<Actuation>) {
        let Some(test) = &mut self.self_test else { return (fault, None) };
        if fault.is_some() {
            *test = SelfTest::new();
            return (fault, None);
        }
        match test.step(inputs) {
            Verdict::Testing(actuation) => (None, Some(actuation)),
            Verdict::Passed => {
                // Vented, as a new observer takes it to be.
                self.observer = Observer::new(test.measured());
                self.measured = true;
                self.self_test = None;
                (None, None)
            }
            Verdict::Failed(part) => {
                let named = test.named(part);
                *test = SelfTest::new();
                self.supervisor.latch(Fault::SelfTest(part));
                self.supervisor.latch(named);
                (self.supervisor.fault(), None)
            }
        }
    }
}
