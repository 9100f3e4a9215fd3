//! From keys to requests. Every question has the same way back (Esc), and `v` vents whatever is open.

use crate::cli;
use model_core::actuation::Segment;
use model_core::protocol::{LinkCommand, SequenceName};
use model_core::sequence::library;
use model_core::units::{Bend, Coefficients, Pressure};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

/// What a key asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Asks the device.
    Ask(LinkCommand),
    /// The operator has seen the alarms.
    Acknowledge,
    /// Vents, and ends the program.
    Quit,
    /// Ends the program and leaves the device as it is.
    Leave,
    /// A replay stands still, or goes on.
    Hold,
    /// A replay jumps by so many seconds.
    Jump(i32),
}

/// What is asked of the operator.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Question {
    /// Nothing.
    #[default]
    None,
    /// Which sequence, index into [`library::ALL`].
    Sequence(usize),
    /// Three pressures in kPa, or three bends in degrees: what was typed, and what was wrong with it.
    Values {
        /// Bends, where pressures otherwise.
        bends: bool,
        /// Typed so far.
        text: String,
        /// Why it was not taken.
        wrong: Option<String>,
    },
    /// Whether to take what the sensors read as zero.
    Zero,
    /// Whether to send the coefficients given on the command line.
    Calibrate,
    /// Whether the device shall use what it has identified, which it was just asked for.
    Adopt,
    /// Nothing, but the keys are explained.
    Help,
}

/// What the keys do at the moment.
#[derive(Clone, Debug, Default)]
pub struct Keys {
    /// The open question.
    pub question: Question,
    /// Coefficients given on the command line.
    pub calibration: [Option<Coefficients>; 3],
    /// A recording is played: nothing can be asked of a device.
    pub replay: bool,
}

/// The requests that give each segment its coefficients.
#[must_use]
pub fn calibrate(coefficients: &[Option<Coefficients>; 3]) -> Vec<LinkCommand> {
    let each = Segment::ALL.into_iter().zip(coefficients).filter_map(|(segment, own)| Some((segment, (*own)?)));
    each.map(|(segment, own)| LinkCommand::Calibrate {
        segment,
        k: own.k().to_bits(),
        c1: own.c1().to_bits(),
        c2: own.c2().to_bits(),
    })
    .collect()
}

impl Keys {
    /// Takes a key.
    pub fn press(&mut self, key: KeyEvent) -> Vec<Action> {
        if key.kind == KeyEventKind::Release {
            return Vec::new();
        }
        if key.modifiers.contains(KeyModifiers::CONTROL) {
            return if key.code == KeyCode::Char('c') { vec![Action::Quit] } else { Vec::new() };
        }
        match key.code {
            KeyCode::Char('v' | 'V') if !self.replay => {
                self.question = Question::None;
                vec![Action::Ask(LinkCommand::Vent)]
            }
            KeyCode::Esc => {
                self.question = Question::None;
                Vec::new()
            }
            code => match core::mem::take(&mut self.question) {
                Question::None => self.command(code),
                Question::Help => Vec::new(),
                Question::Sequence(index) => self.sequence(index, code),
                Question::Values { bends, text, .. } => self.values(bends, text, code),
                Question::Zero => confirmed(code, || vec![LinkCommand::ZeroSensors]),
                Question::Calibrate => confirmed(code, || calibrate(&self.calibration)),
                Question::Adopt => confirmed(code, || vec![LinkCommand::AdoptIdentified]),
            },
        }
    }

    fn command(&mut self, code: KeyCode) -> Vec<Action> {
        let ask = |command| vec![Action::Ask(command)];
        match code {
            KeyCode::Char('q') => return vec![Action::Quit],
            KeyCode::Char('?' | 'h') => self.question = Question::Help,
            KeyCode::Char('a') => return vec![Action::Acknowledge],
            KeyCode::Char(' ') if self.replay => return vec![Action::Hold],
            KeyCode::Left if self.replay => return vec![Action::Jump(-5)],
            KeyCode::Right if self.replay => return vec![Action::Jump(5)],
            _ if self.replay => {}
            KeyCode::Char('Q') => return vec![Action::Leave],
            KeyCode::Char('r') => self.question = Question::Sequence(0),
            KeyCode::Char('p') => return ask(LinkCommand::Pause),
            KeyCode::Char('g') => return ask(LinkCommand::Resume),
            KeyCode::Char('c') => return ask(LinkCommand::ClearFault),
            KeyCode::Char('z') => self.question = Question::Zero,
            KeyCode::Char('i') => {
                self.question = Question::Adopt;
                return ask(LinkCommand::Identification);
            }
            KeyCode::Char('l') if self.calibration.iter().any(Option::is_some) => self.question = Question::Calibrate,
            KeyCode::Char(key @ ('s' | 'b')) => {
                self.question = Question::Values { bends: key == 'b', text: String::new(), wrong: None };
            }
            _ => {}
        }
        Vec::new()
    }

    fn sequence(&mut self, index: usize, code: KeyCode) -> Vec<Action> {
        let all = library::ALL.len();
        let next = match code {
            KeyCode::Down | KeyCode::Char('j') => (index + 1) % all,
            KeyCode::Up | KeyCode::Char('k') => (index + all - 1) % all,
            KeyCode::Enter => {
                let name = library::ALL.get(index).and_then(|sequence| SequenceName::try_from(sequence.name).ok());
                return name.map(|name| Action::Ask(LinkCommand::Run(name))).into_iter().collect();
            }
            _ => index,
        };
        self.question = Question::Sequence(next);
        Vec::new()
    }

    fn values(&mut self, bends: bool, mut text: String, code: KeyCode) -> Vec<Action> {
        let mut wrong = None;
        match code {
            KeyCode::Char(letter @ ('0'..='9' | '.' | ',' | ' ' | '-')) => text.push(letter),
            KeyCode::Backspace => drop(text.pop()),
            KeyCode::Enter => {
                let command = if bends {
                    cli::bends(&text).map(|all| LinkCommand::Bends(all.map(Bend::to_bits)))
                } else {
                    cli::setpoints(&text).map(|all| LinkCommand::Setpoints(all.map(Pressure::to_bits)))
                };
                match command {
                    Ok(command) => return vec![Action::Ask(command)],
                    Err(why) => wrong = Some(why),
                }
            }
            _ => {}
        }
        self.question = Question::Values { bends, text, wrong };
        Vec::new()
    }
}

/// The requests, when the key says yes.
fn confirmed(code: KeyCode, requests: impl FnOnce() -> Vec<LinkCommand>) -> Vec<Action> {
    match code {
        KeyCode::Enter | KeyCode::Char('y') => requests().into_iter().map(Action::Ask).collect(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::run;
    use super::*;

    fn press(keys: &mut Keys, codes: &[KeyCode]) -> Vec<Action> {
        codes.iter().flat_map(|&code| keys.press(KeyEvent::new(code, KeyModifiers::NONE))).collect()
    }

    fn letters(text: &str) -> Vec<KeyCode> {
        text.chars().map(KeyCode::Char).collect()
    }

    #[test]
    fn venting_wins_over_every_open_question() {
        for opener in letters("rsbzil?q") {
            let mut keys = Keys { calibration: [Some(model_core::calibration::DEFAULT); 3], ..Keys::default() };
            press(&mut keys, &[opener]);
            assert_eq!(press(&mut keys, &letters("v")), [Action::Ask(LinkCommand::Vent)], "{opener:?}");
            assert_eq!(keys.question, Question::None);
        }
    }

    #[test]
    fn a_sequence_is_chosen_from_the_list() {
        let mut keys = Keys::default();
        let chosen = press(&mut keys, &[KeyCode::Char('r'), KeyCode::Down, KeyCode::Down, KeyCode::Up, KeyCode::Enter]);
        assert_eq!(chosen, [Action::Ask(run(library::ALL[1].name))]);
        let last = press(&mut keys, &[KeyCode::Char('r'), KeyCode::Up, KeyCode::Enter]);
        assert_eq!(last, [Action::Ask(run(library::ALL[library::ALL.len() - 1].name))]);
        assert_eq!(press(&mut keys, &[KeyCode::Char('r'), KeyCode::Esc, KeyCode::Enter]), []);
    }

    #[test]
    fn typed_values_are_checked_before_they_are_sent() {
        let mut keys = Keys::default();
        press(&mut keys, &letters("s60,30,151"));
        assert_eq!(press(&mut keys, &[KeyCode::Enter]), []);
        let Question::Values { wrong: Some(why), .. } = &keys.question else { panic!("{:?}", keys.question) };
        assert!(why.contains("151") && why.contains("150"), "{why}");
        let sent = press(&mut keys, &[KeyCode::Backspace, KeyCode::Backspace, KeyCode::Enter]);
        assert_eq!(sent, [Action::Ask(LinkCommand::Setpoints([60 << 16, 30 << 16, 1 << 16]))]);
        let sent = press(&mut keys, &[letters("b45,30,15"), vec![KeyCode::Enter]].concat());
        assert_eq!(sent, [Action::Ask(LinkCommand::Bends([45 << 16, 30 << 16, 15 << 16]))]);
    }

    #[test]
    fn zeroing_and_calibrating_ask_first() {
        let mut keys = Keys::default();
        assert_eq!(press(&mut keys, &letters("zn")), []);
        assert_eq!(press(&mut keys, &letters("zy")), [Action::Ask(LinkCommand::ZeroSensors)]);
        assert_eq!(press(&mut keys, &letters("in")), [Action::Ask(LinkCommand::Identification)]);
        let adopts = [LinkCommand::Identification, LinkCommand::AdoptIdentified].map(Action::Ask);
        assert_eq!(press(&mut keys, &letters("iy")), adopts);
        assert_eq!(press(&mut keys, &letters("ly")), [], "no coefficients were given");
        keys.calibration[1] = Some(model_core::calibration::DEFAULT);
        let sent = press(&mut keys, &letters("ly"));
        assert!(matches!(sent[..], [Action::Ask(LinkCommand::Calibrate { segment: Segment::Middle, .. })]), "{sent:?}");
    }

    #[test]
    fn a_replay_asks_nothing_of_a_device() {
        let mut keys = Keys { replay: true, ..Keys::default() };
        assert_eq!(press(&mut keys, &letters("vrpgczsbi")), []);
        assert_eq!(press(&mut keys, &letters(" aq")), [Action::Hold, Action::Acknowledge, Action::Quit]);
    }
}
