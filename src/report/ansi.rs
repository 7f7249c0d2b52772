//! Colours on a terminal (ECMA-48, "select graphic rendition"): viridis behind characters.

use super::color::viridis_rgb;
use std::fmt::Write;

/// Colours that a terminal has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ink {
    /// None, or what is written goes elsewhere.
    #[default]
    None,
    /// The 6 × 6 × 6 cube of xterm.
    Cube,
    /// 24 bits.
    True,
}

/// What is behind a character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ground {
    /// The terminal's own ground.
    Bare,
    /// So far from the lowest to the highest value.
    Share(f64),
}

impl Ink {
    /// Appends a line, without blanks at its end where nothing is behind them.
    pub(super) fn write_line(self, line: &[(char, Ground)], text: &mut String) {
        let is_blank = |&(c, ground): &(char, Ground)| {
            c == ' ' && (self == Ink::None || ground == Ground::Bare)
        };
        let end = line.iter().rposition(|square| !is_blank(square));
        let mut present = Ground::Bare;
        for &(c, ground) in &line[..end.map_or(0, |end| end + 1)] {
            if self != Ink::None && ground != present {
                self.change(ground, text);
                present = ground;
            }
            text.push(c);
        }
        if present != Ground::Bare {
            self.change(Ground::Bare, text);
        }
        text.push('\n');
    }

    fn change(self, ground: Ground, text: &mut String) {
        let Ground::Share(share) = ground else {
            text.push_str("\x1b[0m");
            return;
        };
        let [red, green, blue] = viridis_rgb(share);
        // Rec. 709 luma: black on light ground, white on dark.
        let luma = 0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue);
        let letter = if luma > 128.0 { 16 } else { 231 };
        let behind = match self {
            Ink::None => return,
            Ink::Cube => {
                let step = |level: u8| (u32::from(level) * 5 + 127) / 255;
                format!(
                    "48;5;{}",
                    16 + 36 * step(red) + 6 * step(green) + step(blue)
                )
            }
            Ink::True => format!("48;2;{red};{green};{blue}"),
        };
        let _ = write!(text, "\x1b[{behind};38;5;{letter}m");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_change_only_where_they_must() {
        let low = Ground::Share(0.0);
        let line = [
            ('a', low),
            (' ', low),
            ('b', Ground::Bare),
            (' ', Ground::Bare),
        ];
        let written = |ink: Ink| {
            let mut text = String::new();
            ink.write_line(&line, &mut text);
            text
        };
        assert_eq!(written(Ink::None), "a b\n");
        assert_eq!(
            written(Ink::True),
            "\x1b[48;2;68;1;84;38;5;231ma \x1b[0mb\n"
        );
        assert_eq!(written(Ink::Cube), "\x1b[48;5;54;38;5;231ma \x1b[0mb\n");
    }

    #[test]
    fn a_coloured_end_of_a_line_is_kept() {
        let mut text = String::new();
        Ink::True.write_line(&[(' ', Ground::Share(1.0))], &mut text);
        assert_eq!(text, "\x1b[48;2;253;231;37;38;5;16m \x1b[0m\n");
    }
}
