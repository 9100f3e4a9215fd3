//! A run, drawn from seed and index alone: any run can be made again without the others.
//!
//! Plant, program, faults and noise have generators of their own, so that a filter for one of them leaves the others as they are.

use super::kind::Kind;
use crate::plant::{FaultKind, InjectedFault, PlantParameters};
use model_core::actuation::{Passage, PerSegment, Segment};
use model_core::sequence::{Sequence, library};
use model_core::units::{Bend, Coefficients, Pressure};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Which runs are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Filter {
    /// Every run has this fault, and at most one other.
    pub fault: Option<Kind>,
    /// Every run has this program.
    pub program: Option<Choice>,
}

/// A program by its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Choice {
    /// A built-in sequence.
    Sequence(&'static Sequence),
    /// Pressures by hand.
    ByHand,
    /// Bends by hand.
    ByHandDegrees,
}

/// The name of setpoints by hand in tables and on the command line.
pub const BY_HAND: &str = "by-hand";
/// The same for bends.
pub const BY_HAND_DEGREES: &str = "by-hand-degrees";

impl Choice {
    const HANDS: [Self; 2] = [Self::ByHand, Self::ByHandDegrees];

    /// All, in the matrix's order.
    #[must_use]
    pub fn all() -> Vec<Self> {
        library::ALL.into_iter().map(Self::Sequence).chain(Self::HANDS).collect()
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sequence(sequence) => sequence.name,
            Self::ByHand => BY_HAND,
            Self::ByHandDegrees => BY_HAND_DEGREES,
        }
    }

    /// The program of this name.
    ///
    /// # Errors
    /// Names those that there are.
    pub fn find(name: &str) -> Result<Self, String> {
        Self::all().into_iter().find(|choice| choice.name() == name).ok_or_else(|| {
            let known: Vec<_> = Self::all().iter().map(|choice| choice.name()).collect();
            format!("no sequence is named {name:?}; there are {}", known.join(", "))
        })
    }
}

/// What a hand asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wish {
    /// Pressures of the chambers.
    Pressures(PerSegment<Pressure>),
    /// Bends of the segments.
    Bends(PerSegment<Bend>),
}

/// What the controller is asked for.
#[derive(Clone, Debug)]
pub enum Program {
    /// A built-in sequence.
    Sequence(&'static Sequence),
    /// A host drives the finger by setpoints, each held for so many ms; then it vents.
    ByHand(Vec<(Wish, u32)>),
}

impl Program {
    /// Its name in tables.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sequence(sequence) => sequence.name,
            Self::ByHand(wishes) if matches!(wishes.first(), Some((Wish::Bends(_), _))) => BY_HAND_DEGREES,
            Self::ByHand(_) => BY_HAND,
        }
    }

    /// How long it takes, ms.
    #[must_use]
    pub fn duration_ms(&self) -> u32 {
        match self {
            Self::Sequence(sequence) => sequence.duration().0,
            Self::ByHand(setpoints) => setpoints.iter().map(|&(_, hold_ms)| hold_ms).sum(),
        }
    }
}

/// What a fault does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// To the plant.
    Plant(FaultKind),
    /// To the link.
    SilentHost,
    /// To the controller's ticks: one of so many comes two ticks late.
    LateTick {
        /// Of so many ticks one.
        of: u32,
    },
    /// To the controller: it does not step until the watchdog's reset.
    Hang,
    /// To the supply: everything is without power for so many ms.
    Dip {
        /// How long.
        ms: u32,
    },
    /// To the settings: damaged at the start.
    Settings,
    /// To the machine from the start: its valves' dead times are this many times what was drawn.
    ColdValves {
        /// Factor.
        times: u32,
    },
    /// Nothing: the program is too long for a session.
    LongSession,
}

/// A fault of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawn {
    /// Of which kind.
    pub kind: Kind,
    /// What it does.
    pub what: What,
    /// In which segment, where there is one for each.
    pub segment: Segment,
    /// First tick with it, ms.
    pub from_ms: u32,
}

impl Drawn {
    /// What is injected into the plant.
    #[must_use]
    pub fn injected(&self) -> Option<InjectedFault> {
        match self.what {
            What::Plant(kind) => Some(InjectedFault::lasting(kind, self.from_ms)),
            _ => None,
        }
    }
}

/// One run of a campaign.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its number, from zero.
    pub index: u64,
    /// The machine.
    pub plant: PlantParameters,
    /// What the controller was calibrated to.
    pub calibration: PerSegment<Coefficients>,
    /// What it is asked for.
    pub program: Program,
    /// Whether a host is heard while a sequence runs, which needs none.
    pub host_listens: bool,
    /// What breaks: nothing, one part, or two.
    pub faults: Vec<Drawn>,
    /// Seed of the sensors' errors and noise.
    pub noise_seed: u64,
}

/// The finger is asked for something this long after the self test has passed, ms.
pub const STANDBY_MS: u32 = 500;
/// About how long a self test takes, ms: faults come in it too.
const SELF_TEST_MS: u32 = 2500;

/// The switch closes within this of its setting, kPa: its display resolution.
const SWITCH_KPA: f64 = 1.0;

/// One generator of a run: they share nothing but the seed.
fn generator(seed: u64, index: u64, stream: u64) -> Pcg64 {
    // SplitMix64 of each word: neighbours become strangers.
    let mix = |value: u64| {
        let value = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        value ^ (value >> 31)
    };
    let words = [mix(seed), mix(index ^ mix(seed)), mix(stream ^ mix(index)), mix(seed ^ mix(stream))];
    let mut bytes = [0; 32];
    for (bytes, word) in bytes.chunks_exact_mut(8).zip(words) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    Pcg64::from_seed(bytes)
}

/// A factor in `low..high`, its logarithm uniform: half and double are as likely.
fn factor(rng: &mut Pcg64, low: f64, high: f64) -> f64 {
    rng.random_range(low.ln()..high.ln()).exp()
}

/// A plant within the spread that the supervisor must bear without an alarm.
fn plant(rng: &mut Pcg64) -> PlantParameters {
    let mut p = PlantParameters::default();
    p.gas.atmosphere_kpa = rng.random_range(95.0..104.0);
    p.gas.manifold_ml *= factor(rng, 0.8, 1.25);
    p.pump.free_flow_nl_per_min *= factor(rng, 0.5, 1.3);
    p.pump.stall_kpa *= factor(rng, 0.9, 1.1);
    p.pump.spin_up_ms *= factor(rng, 0.5, 2.0);
    p.finger.chamber_ml *= factor(rng, 0.7, 2.0);
    p.finger.volume_growth *= factor(rng, 0.5, 1.5);
    p.finger.lag_ms *= factor(rng, 0.5, 2.0);
    let mut delayed = |ms: u32| (f64::from(ms) * factor(rng, 0.5, 2.0)).round() as u32;
    p.pump.dead_time_ms = delayed(p.pump.dead_time_ms);
    p.segment_valve.dead_time_ms = delayed(p.segment_valve.dead_time_ms);
    p.dump_valve.dead_time_ms = delayed(p.dump_valve.dead_time_ms);
    p.segment_valve.conductance_nl_per_s_bar *= factor(rng, 0.7, 1.4);
    p.dump_valve.conductance_nl_per_s_bar *= factor(rng, 0.7, 1.4);
    let critical_ratio = rng.random_range(0.2..0.4);
    (p.segment_valve.critical_ratio, p.dump_valve.critical_ratio) = (critical_ratio, critical_ratio);
    for [_, c1, c2] in &mut p.finger.coefficients_kpa {
        *c1 *= rng.random_range(0.93..1.07);
        *c2 *= rng.random_range(0.93..1.07);
    }
    p.pressure_sensor.noise_kpa *= factor(rng, 0.5, 1.5);
    p.bend_sensor.noise_deg *= factor(rng, 0.5, 1.5);
    p
}

/// What a calibration of that finger gives: within 3 %.
fn calibration(rng: &mut Pcg64, plant: &PlantParameters) -> PerSegment<Coefficients> {
    plant.finger.coefficients_kpa.map(|[k, c1, c2]| {
        let mut near = |value: f64| value * rng.random_range(0.97..1.03);
        Coefficients::from_f64_kpa(near(k), near(c1), near(c2)).expect("within the admitted range")
    })
}

fn program(rng: &mut Pcg64, filter: &Filter) -> Program {
    let all = Choice::all();
    // By hand in a fifth of the runs, a sequence in the others.
    let hands = Choice::HANDS;
    let drawn = if rng.random_bool(0.2) {
        hands[rng.random_range(0..hands.len())]
    } else {
        all[rng.random_range(0..all.len() - hands.len())]
    };
    match filter.program.unwrap_or(drawn) {
        Choice::Sequence(sequence) => Program::Sequence(sequence),
        Choice::ByHand => {
            let steps = rng.random_range(3..=6);
            let mut setpoint = || Pressure::from_kpa(if rng.random_bool(0.15) { 0 } else { rng.random_range(5..=150) });
            let wishes: Vec<_> = (0..steps).map(|_| Wish::Pressures([setpoint(), setpoint(), setpoint()])).collect();
            held(rng, wishes)
        }
        Choice::ByHandDegrees => {
            let steps = rng.random_range(3..=6);
            let mut bend = || Bend::from_deg(if rng.random_bool(0.15) { 0 } else { rng.random_range(5..=110) });
            let wishes: Vec<_> = (0..steps).map(|_| Wish::Bends([bend(), bend(), bend()])).collect();
            held(rng, wishes)
        }
    }
}

/// Each for 1 to 5 s.
fn held(rng: &mut Pcg64, wishes: Vec<Wish>) -> Program {
    Program::ByHand(wishes.into_iter().map(|wish| (wish, rng.random_range(1000..=5000))).collect())
}

/// A program that a session's limit must end: a pressure that is held for over an hour, or over 2000 bends in less.
fn long_session(kind: Kind) -> Option<Program> {
    let wish = |kpa| Wish::Pressures([Pressure::from_kpa(kpa), Pressure::ZERO, Pressure::ZERO]);
    match kind {
        Kind::SessionTime => Some(Program::ByHand(vec![(wish(40), 3_610_000)])),
        Kind::SessionCycles => Some(Program::ByHand((0..4020).map(|step| (wish(30 - step % 2 * 30), 800)).collect())),
        _ => None,
    }
}

fn fault(rng: &mut Pcg64, kind: Kind, window_ms: u32) -> Drawn {
    let segment = Segment::ALL[rng.random_range(0..3)];
    let from_power_on = rng.random_bool(0.1);
    let mut from_ms = rng.random_range(0..window_ms);
    if from_power_on {
        from_ms = 0;
    }
    let leak = |conductance_nl_per_s_bar| FaultKind::ChamberLeak { segment, conductance_nl_per_s_bar };
    let what = match kind {
        Kind::PressureSensorOpen => What::Plant(FaultKind::PressureSensorOpen),
        Kind::PressureSensorShort => What::Plant(FaultKind::PressureSensorShort),
        Kind::PressureSensorFrozen => What::Plant(FaultKind::PressureSensorFrozen),
        Kind::PressureSensorNoisy => What::Plant(FaultKind::PressureSensorNoisy { times: 10.0 }),
        Kind::SwitchStuckOpen => What::Plant(FaultKind::PressureSwitchStuck(false)),
        Kind::SwitchStuckClosed => What::Plant(FaultKind::PressureSwitchStuck(true)),
        Kind::BendSensorOpen => What::Plant(FaultKind::BendSensorOpen),
        Kind::BendSensorShort => What::Plant(FaultKind::BendSensorShort),
        Kind::BendSensorFrozen => What::Plant(FaultKind::BendSensorFrozen),
        Kind::EmergencyStop => What::Plant(FaultKind::EmergencyStop),
        Kind::PumpStuckOn => What::Plant(FaultKind::PumpStuckOn),
        Kind::PumpDead => What::Plant(FaultKind::PumpDead),
        Kind::PumpWeak => What::Plant(FaultKind::PumpWeak { share: factor(rng, 0.05, 0.3) }),
        Kind::ValveStuckOpen => What::Plant(FaultKind::SegmentValveStuck(segment, Passage::Open)),
        Kind::ValveStuckClosed => What::Plant(FaultKind::SegmentValveStuck(segment, Passage::Closed)),
        Kind::DumpStuckOpen => What::Plant(FaultKind::DumpStuck(Passage::Open)),
        Kind::DumpStuckClosed => What::Plant(FaultKind::DumpStuck(Passage::Closed)),
        Kind::LeakSlow => What::Plant(leak(factor(rng, 1e-4, 5e-4))),
        Kind::LeakBurst => What::Plant(leak(factor(rng, 1e-2, 1e-1))),
        Kind::FingerBlocked => What::Plant(FaultKind::FingerBlocked(segment)),
        Kind::FingerPushed => {
            let degrees = rng.random_range(25.0..75.0) * if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            What::Plant(FaultKind::FingerPushed { segment, degrees })
        }
        Kind::LinkLost => What::SilentHost,
        Kind::TickOverrun => What::LateTick { of: rng.random_range(5..=40) },
        Kind::TaskHang => What::Hang,
        Kind::PowerDip => What::Dip { ms: rng.random_range(5..=300) },
        Kind::SettingsCorrupt => {
            from_ms = 0;
            What::Settings
        }
        Kind::ManifoldLeak => {
            What::Plant(FaultKind::ManifoldLeak { conductance_nl_per_s_bar: factor(rng, 1e-3, 1e-2) })
        }
        Kind::ColdValves => {
            from_ms = 0;
            What::ColdValves { times: 2 }
        }
        Kind::SessionTime | Kind::SessionCycles => {
            from_ms = 0;
            What::LongSession
        }
    };
    Drawn { kind, what, segment, from_ms }
}

fn faults(rng: &mut Pcg64, filter: &Filter, window_ms: u32) -> Vec<Drawn> {
    let any = |rng: &mut Pcg64| Kind::DRAWN[rng.random_range(0..Kind::DRAWN.len())];
    let kind = any(rng);
    // A fifth of the runs has none, a fifth two.
    let number = rng.random_range(0..5);
    if filter.fault.is_none() && number == 0 {
        return vec![];
    }
    let first = fault(rng, filter.fault.unwrap_or(kind), window_ms);
    let part = |drawn: &Drawn| drawn.kind.part(drawn.segment);
    let mut drawn = vec![first];
    while number == 4 && drawn.len() < 2 {
        let kind = any(rng);
        let second = fault(rng, kind, window_ms);
        if part(&second) != part(&first) {
            drawn.push(second);
        }
    }
    drawn
}

impl Case {
    /// The run with this number of the campaign with this seed.
    #[must_use]
    pub fn draw(seed: u64, index: u64, filter: &Filter) -> Self {
        let mut machine = generator(seed, index, 0);
        let mut plant = plant(&mut machine);
        let calibration = calibration(&mut machine, &plant);
        let mut wish = generator(seed, index, 1);
        let host_listens = wish.random_bool(0.5);
        let mut program = program(&mut wish, filter);
        let window_ms = SELF_TEST_MS + STANDBY_MS + program.duration_ms();
        let faults = faults(&mut generator(seed, index, 2), filter, window_ms);
        for fault in &faults {
            if let What::ColdValves { times } = fault.what {
                plant.segment_valve.dead_time_ms *= times;
                plant.dump_valve.dead_time_ms *= times;
            }
            program = long_session(fault.kind).unwrap_or(program);
        }
        let noise_seed = generator(seed, index, 3).random();
        plant.pressure_sensor.switch_kpa += generator(seed, index, 4).random_range(-SWITCH_KPA..SWITCH_KPA);
        Self { index, plant, calibration, program, host_listens, faults, noise_seed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_depends_on_seed_and_index_and_nothing_else() {
        let filter = Filter::default();
        let text = |seed, index| format!("{:?}", Case::draw(seed, index, &filter));
        assert_eq!(text(1, 5), text(1, 5));
        assert_ne!(text(1, 5), text(1, 6));
        assert_ne!(text(1, 5), text(2, 5));
    }

    #[test]
    fn a_filter_changes_what_it_is_for_and_nothing_else() {
        let filter = Filter { fault: Some(Kind::PumpDead), program: Some(Choice::ByHand) };
        for index in 0..200 {
            let (free, filtered) = (Case::draw(3, index, &Filter::default()), Case::draw(3, index, &filter));
            // Cold valves are a fault of the machine itself.
            let cold = |case: &Case| case.faults.iter().any(|fault| fault.kind == Kind::ColdValves);
            assert!(cold(&free) || cold(&filtered) || free.plant == filtered.plant, "{index}");
            assert_eq!(free.noise_seed, filtered.noise_seed);
            assert_eq!(filtered.program.name(), BY_HAND);
            assert_eq!(filtered.faults[0].kind, Kind::PumpDead);
        }
    }

    #[test]
    fn every_kind_and_program_comes_and_two_at_once_too() {
        let cases: Vec<_> = (0..3000).map(|index| Case::draw(7, index, &Filter::default())).collect();
        for &kind in Kind::DRAWN {
            assert!(cases.iter().any(|case| case.faults.iter().any(|fault| fault.kind == kind)), "{kind:?}");
        }
        for choice in Choice::all() {
            assert!(cases.iter().any(|case| case.program.name() == choice.name()));
        }
        for (number, share) in [(0, 0.2), (1, 0.6), (2, 0.2)] {
            let drawn = cases.iter().filter(|case| case.faults.len() == number).count() as f64 / 3000.0;
            assert!((drawn - share).abs() < 0.04, "{number}: {drawn}");
        }
    }
}
