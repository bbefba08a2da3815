//! The picture.

use std::fmt::Write as _;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph};
use world::can::{Id, Logged, Source};
use world::lcd_chip::{COLUMNS, PLACES};

use super::Screen;
use crate::glance::Glance;
use crate::hex;

const LIT: Style = Style::new().fg(Color::Black).bg(Color::Gray).add_modifier(Modifier::BOLD);
const DARK: Style = Style::new().fg(Color::DarkGray).bg(Color::Gray);

/// Rows of one digit.
const DIGIT_ROWS: usize = 3;
/// Two lines of digits, the arrows below them, and a margin.
const GLASS_ROWS: u16 = 9;
const GLASS_WIDTH: u16 = 34;

/// Draws what `screen` knows.
pub(super) fn draw(frame: &mut Frame<'_>, screen: &Screen, places: &str) {
    let Some(glance) = &screen.glance else {
        frame.render_widget("The bench is busy.", frame.area());
        return;
    };
    let [head, middle, trace, log, foot] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(GLASS_ROWS + 2),
        Constraint::Fill(2),
        Constraint::Fill(1),
        Constraint::Length(2),
    ])
    .areas(frame.area());
    let [left, right] =
        Layout::horizontal([Constraint::Length(GLASS_WIDTH), Constraint::Fill(1)]).areas(middle);

    frame.render_widget(title(screen, glance, places), head);
    frame.render_widget(
        Paragraph::new(glass(&glance.segments)).block(Block::bordered().title("display")),
        left,
    );
    frame.render_widget(
        Paragraph::new(state(glance)).block(Block::bordered().title("device")),
        right,
    );
    frame.render_widget(newest(screen.trace.iter().map(trace_line), "CAN bus", trace), trace);
    frame.render_widget(newest(glance.log.iter().map(log_line), "log", log), log);
    frame.render_widget(Paragraph::new(KEYS), foot);
}

const KEYS: &str = "\
←/→ turn (shift: 4 turns)  ↑/↓ turn steadily  space stop  a/d left/right key (press again: let go)
f/g inputs F/G  p supply  tab next device  q quit";

fn title(screen: &Screen, glance: &Glance, places: &str) -> String {
    let us = glance.now.as_micros();
    format!(
        "device {} of {}   {}.{:03} s   {:.2}× real time   {places}",
        screen.node + 1,
        screen.nodes,
        us / 1_000_000,
        us / 1_000 % 1_000,
        glance.factor,
    )
}

/// The glass, every segment drawn, the lit ones dark.
fn glass(segments: &[u8; COLUMNS]) -> Vec<Line<'static>> {
    let mut lines = vec![Line::default()];
    for first in [0, PLACES] {
        for row in 0..DIGIT_ROWS {
            let mut spans = vec![Span::raw("   ")];
            for digit in first..first + PLACES {
                spans.extend(digit_row(segments, digit, row));
            }
            lines.push(Line::from(spans));
        }
    }
    let arrows = column(segments, 2 * 2 * PLACES);
    lines.push(Line::from(vec![
        Span::raw("   "),
        segment(arrows & 0b1000 != 0, "◀"),
        Span::styled(" ".repeat(4 * PLACES - 2), DARK),
        segment(arrows & 0b0100 != 0, "▶"),
    ]));
    lines
}

/// One of the three rows of a digit: column 2d carries a, b, c and the point on backplanes 0 to 3,
/// column 2d + 1 f, g, e, d.
fn digit_row(segments: &[u8; COLUMNS], digit: usize, row: usize) -> Vec<Span<'static>> {
    let abcp = column(segments, 2 * digit);
    let fged = column(segments, 2 * digit + 1);
    let lit = |column: u8, backplane: u8| column & (0b1000 >> backplane) != 0;
    let blank = || Span::styled(" ", DARK);
    match row {
        0 => vec![blank(), segment(lit(abcp, 0), "_"), blank(), blank()],
        1 => vec![
            segment(lit(fged, 0), "|"),
            segment(lit(fged, 1), "_"),
            segment(lit(abcp, 1), "|"),
            blank(),
        ],
        _ => vec![
            segment(lit(fged, 2), "|"),
            segment(lit(fged, 3), "_"),
            segment(lit(abcp, 2), "|"),
            segment(lit(abcp, 3), "."),
        ],
    }
}

fn column(segments: &[u8; COLUMNS], column: usize) -> u8 {
    segments.get(column).copied().unwrap_or(0)
}

fn segment(lit: bool, sign: &'static str) -> Span<'static> {
    if lit { Span::styled(sign, LIT) } else { Span::styled(" ", DARK) }
}

fn state(glance: &Glance) -> Vec<Line<'static>> {
    let on = |on: bool| if on { "on " } else { "off" };
    let down = |down: bool| if down { "down" } else { "up  " };
    let motor = glance.motor;
    let mut faults = String::new();
    if glance.link.cut {
        faults.push_str("link cut  ");
    }
    if glance.faults.no_ack {
        faults.push_str("nobody acknowledges  ");
    }
    if glance.faults.stuck_dominant {
        faults.push_str("bus stuck dominant  ");
    }
    let lines = vec![
        format!("supply     {}", on(glance.powered)),
        format!("sensor     {}   {:+} steps/s", glance.raw, glance.steps_per_s),
        format!(
            "motor      IN1 {} IN2 {} IN3 {} IN4 {}",
            on(motor.in1),
            on(motor.in2),
            on(motor.in3),
            on(motor.in4)
        ),
        format!(
            "keys       left {}  right {}",
            down(glance.panel.left_key),
            down(glance.panel.right_key)
        ),
        format!("inputs     F {}  G {}", on(glance.panel.input_f), on(glance.panel.input_g)),
        format!("bus errors {}", glance.error_frames),
        format!("faults     {}", if faults.is_empty() { "none" } else { faults.trim() }),
    ];
    lines.into_iter().map(Line::from).collect()
}

/// The last of `lines` that fit into `area`.
fn newest(
    lines: impl DoubleEndedIterator<Item = String>,
    title: &'static str,
    area: Rect,
) -> Paragraph<'static> {
    let rows = usize::from(area.height.saturating_sub(2));
    let mut shown: Vec<Line<'static>> = lines.rev().take(rows).map(Line::from).collect();
    shown.reverse();
    Paragraph::new(shown).block(Block::bordered().title(title))
}

fn trace_line(logged: &Logged) -> String {
    let us = logged.end.instant().as_micros();
    let from = match logged.source {
        Source::Device(node) => format!("device {}", node + 1),
        Source::Outside(_) => "outside".to_owned(),
    };
    let id = match logged.frame.id() {
        Id::Standard(id) => format!("     {id:03X}"),
        Id::Extended(id) => format!("{id:08X}"),
    };
    let mut line = format!("{:>8}.{:06}  {from:<10}{id}  ", us / 1_000_000, us % 1_000_000);
    let dlc = logged.frame.dlc();
    if logged.frame.is_remote() {
        // Writing to a String can not fail.
        let _ = write!(line, "[{dlc}] remote");
    } else {
        let bytes: Vec<String> = logged.frame.data().iter().map(|b| hex::upper(&[*b])).collect();
        let _ = write!(line, "[{dlc}] {}", bytes.join(" "));
    }
    line
}

fn log_line(line: &world::LogLine) -> String {
    let us = line.at.as_micros();
    format!(
        "{:>8}.{:06}  {}  {:<5} {}",
        us / 1_000_000,
        us % 1_000_000,
        line.mcu.name(),
        line.level,
        line.text
    )
}

#[cfg(test)]
mod tests {
    use expect_test::{Expect, expect};

    use super::*;

    /// What is lit, without colours.
    #[track_caller]
    fn check(columns: &[(usize, u8)], expected: &Expect) {
        let mut segments = [0; COLUMNS];
        for &(column, lit) in columns {
            segments[column] = lit;
        }
        let picture: String = glass(&segments)
            .iter()
            .map(|line| {
                let text: String = line.spans.iter().map(|span| span.content.as_ref()).collect();
                format!("|{}\n", text.trim_end())
            })
            .collect();
        expected.assert_eq(&picture);
    }

    #[test]
    fn every_segment_is_in_its_place() {
        check(
            &[(0, 0b1111), (1, 0b1111), (2, 0b0110), (23, 0b0100), (24, 0b1100)],
            &expect![[r#"
                |
                |    _
                |   |_|   |
                |   |_|.  |
                |
                |                        _
                |
                |   ◀                      ▶
            "#]],
        );
    }
}
