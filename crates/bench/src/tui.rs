//! The terminal user interface: the glass of one device, its motor, keys to press, the bus.
//!
//! | key | does |
//! |---|---|
//! | arrow left, right | turns the shaft by 1/64 turn, with shift by 4 turns |
//! | arrow down, up | turns it steadily, slower or faster, down below zero |
//! | space | stops it |
//! | a, d | presses the left, right front key; again lets go |
//! | f, g | switches input F, G |
//! | p | switches the supply off and on |
//! | tab | shows the next device |
//! | q, Ctrl-C | ends the bench |
//!
//! A terminal does not tell when a key is let go, so a front key stays down until it is pressed a
//! second time.

mod draw;

use std::collections::VecDeque;
use std::io;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::Duration;

use ratatui::crossterm::event::{
    self, Event as Input, KeyCode, KeyEvent, KeyEventKind, KeyModifiers,
};
use world::can::{LogCursor, Logged};

use crate::Bench;
use crate::control::{self, Request, Turn};
use crate::glance::Glance;
use crate::run::{Event, Look};

/// How long a picture stands.
const PICTURE_TIME: Duration = Duration::from_millis(50);

/// How long the run may take to answer a look before the picture is drawn without.
const ANSWER_TIME: Duration = Duration::from_millis(500);

/// Frames of the bus kept for the picture.
const TRACE_MAX: usize = 200;

/// Sensor steps of one press of an arrow key: 1/64 turn.
const SMALL_TURN: i32 = 64;
/// With shift: four turns.
const LARGE_TURN: i32 = 4 * 4096;
/// What up and down change the steady speed by, in sensor steps per second: 1/4 turn.
const SPEED_STEP: i32 = 1024;

/// What the terminal remembers between two pictures.
struct Screen {
    node: usize,
    nodes: usize,
    speed: i32,
    seen: LogCursor,
    trace: VecDeque<Logged>,
    glance: Option<Glance>,
    /// Where the answer to the last look will come, while the run is too busy to give it.
    awaited: Option<Receiver<Glance>>,
}

/// What a key press means.
#[derive(Clone, Debug, PartialEq)]
enum Press {
    Ask(Request),
    NextNode,
    Quit,
    Nothing,
}

/// Shows the bench until the user or something else ends it.
///
/// # Errors
/// When the terminal can not be used.
pub fn show(bench: &Bench) -> io::Result<()> {
    let mut terminal = ratatui::try_init()?;
    let shown = pictures(bench, &mut terminal);
    ratatui::try_restore()?;
    shown
}

fn pictures(bench: &Bench, terminal: &mut ratatui::DefaultTerminal) -> io::Result<()> {
    let stopper = bench.stopper();
    let mut screen = Screen::new(bench.nodes());
    let places = format!("SLCAN {}   control {}", bench.slcan(), bench.control());
    while !stopper.stopped() {
        screen.look(bench);
        terminal.draw(|frame| draw::draw(frame, &screen, &places))?;
        if screen.failed() {
            return Ok(());
        }
        if !event::poll(PICTURE_TIME)? {
            continue;
        }
        if let Input::Key(key) = event::read()? {
            match screen.press(key) {
                Press::Ask(request) => {
                    // The run is over when nobody takes it; the loop sees that.
                    let _ = bench.events().send(Event::Do(screen.node, request));
                }
                Press::NextNode => screen.node = (screen.node + 1) % screen.nodes,
                Press::Quit => return Ok(()),
                Press::Nothing => {}
            }
        }
    }
    Ok(())
}

impl Screen {
    fn new(nodes: usize) -> Self {
        Self {
            node: 0,
            nodes,
            speed: 0,
            seen: LogCursor::default(),
            trace: VecDeque::new(),
            glance: None,
            awaited: None,
        }
    }

    fn look(&mut self, bench: &Bench) {
        let Some(answered) = self.awaited.take().or_else(|| self.ask_for_look(bench)) else {
            return;
        };
        match answered.recv_timeout(ANSWER_TIME) {
            Ok(glance) => self.see(glance),
            Err(RecvTimeoutError::Timeout) => self.awaited = Some(answered),
            Err(RecvTimeoutError::Disconnected) => {}
        }
    }

    fn ask_for_look(&self, bench: &Bench) -> Option<Receiver<Glance>> {
        let (answer, answered) = mpsc::sync_channel(1);
        let look = Look { node: self.node, since: self.seen, answer };
        bench.events().send(Event::Look(look)).ok().map(|()| answered)
    }

    fn see(&mut self, glance: Glance) {
        self.seen = glance.next;
        self.trace.extend(&glance.frames);
        while self.trace.len() > TRACE_MAX {
            self.trace.pop_front();
        }
        self.glance = Some(glance);
    }

    fn failed(&self) -> bool {
        self.glance.as_ref().is_some_and(|glance| glance.failure.is_some())
    }

    #[expect(clippy::wildcard_enum_match_arm, reason = "most keys of a keyboard mean nothing here")]
    fn press(&mut self, key: KeyEvent) -> Press {
        if key.kind == KeyEventKind::Release {
            return Press::Nothing;
        }
        let panel = self.glance.as_ref().map(|glance| glance.panel).unwrap_or_default();
        let powered = self.glance.as_ref().is_none_or(|glance| glance.powered);
        let step =
            if key.modifiers.contains(KeyModifiers::SHIFT) { LARGE_TURN } else { SMALL_TURN };
        let request = match key.code {
            KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => {
                return Press::Quit;
            }
            KeyCode::Char('q') => return Press::Quit,
            KeyCode::Tab => return Press::NextNode,
            KeyCode::Left => Request::Shaft(Turn::By(-step)),
            KeyCode::Right => Request::Shaft(Turn::By(step)),
            KeyCode::Up => self.steadily(self.speed.saturating_add(SPEED_STEP)),
            KeyCode::Down => self.steadily(self.speed.saturating_sub(SPEED_STEP)),
            KeyCode::Char(' ') => self.steadily(0),
            KeyCode::Char('a') => Request::Key(control::Key::Left, !panel.left_key),
            KeyCode::Char('d') => Request::Key(control::Key::Right, !panel.right_key),
            KeyCode::Char('f') => Request::Input(control::Input::F, !panel.input_f),
            KeyCode::Char('g') => Request::Input(control::Input::G, !panel.input_g),
            KeyCode::Char('p') => Request::Power(!powered),
            _ => return Press::Nothing,
        };
        Press::Ask(request)
    }

    fn steadily(&mut self, speed: i32) -> Request {
        self.speed = speed;
        Request::Shaft(Turn::Steadily(speed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_do_what_the_table_says() {
        let plain = |code| KeyEvent::new(code, KeyModifiers::NONE);
        let shifted = |code| KeyEvent::new(code, KeyModifiers::SHIFT);
        let ask = |turn| Press::Ask(Request::Shaft(turn));
        let mut screen = Screen::new(2);
        for (key, expected) in [
            (plain(KeyCode::Left), ask(Turn::By(-64))),
            (plain(KeyCode::Right), ask(Turn::By(64))),
            (shifted(KeyCode::Right), ask(Turn::By(16_384))),
            (plain(KeyCode::Up), ask(Turn::Steadily(1_024))),
            (plain(KeyCode::Up), ask(Turn::Steadily(2_048))),
            (plain(KeyCode::Down), ask(Turn::Steadily(1_024))),
            (plain(KeyCode::Char(' ')), ask(Turn::Steadily(0))),
            (plain(KeyCode::Char('a')), Press::Ask(Request::Key(control::Key::Left, true))),
            (plain(KeyCode::Char('g')), Press::Ask(Request::Input(control::Input::G, true))),
            (plain(KeyCode::Char('p')), Press::Ask(Request::Power(false))),
            (plain(KeyCode::Tab), Press::NextNode),
            (plain(KeyCode::Char('q')), Press::Quit),
            (KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL), Press::Quit),
            (plain(KeyCode::Char('x')), Press::Nothing),
        ] {
            assert_eq!(screen.press(key), expected, "{key:?}");
        }
    }
}
