//! The direct calls and jumps in Thumb-2 code (Armv7-M Architecture Reference Manual, A5 and A7).

/// A call, or a jump out of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Call {
    /// Where it stands.
    pub(super) at: u64,
    /// Where it leads.
    pub(super) to: u64,
}

/// What the function `code` at the address `start` calls. Data between instructions is left out.
pub(super) fn calls(code: &[u8], start: u64, is_code: impl Fn(u64) -> bool) -> Vec<Call> {
    let own = start..start + code.len() as u64;
    let halves: Vec<u16> =
        code.as_chunks().0.iter().map(|pair| u16::from_le_bytes(*pair)).collect();
    let mut calls = Vec::new();
    let (mut at, mut rest) = (start, halves.as_slice());
    while let [first, behind @ ..] = rest {
        let (offset, next) = match behind {
            _ if !is_code(at) => (None, behind),
            [second, next @ ..] if is_long(*first) => (long_branch(*first, *second), next),
            _ => (short_branch(*first), behind),
        };
        // The program counter reads four bytes ahead.
        let to = offset.and_then(|offset| at.checked_add(4)?.checked_add_signed(offset));
        if let Some(to) = to.filter(|to| !own.contains(to) || *to == start) {
            calls.push(Call { at, to });
        }
        at += 2 * (rest.len() - next.len()) as u64;
        rest = next;
    }
    calls
}

/// Whether an instruction has a second half (A5.1).
const fn is_long(first: u16) -> bool {
    first >> 11 >= 0b11101
}

/// BL, B.W, and B.W with a condition (A7.7.12 and A7.7.18).
fn long_branch(first: u16, second: u16) -> Option<i64> {
    if first >> 11 != 0b11110 || second >> 15 == 0 {
        return None;
    }
    let bit = |half: u16, n: u16| i64::from(half >> n & 1);
    let sign = bit(first, 10);
    let (j1, j2, low) = (bit(second, 13), bit(second, 11), i64::from(second & 0x7FF));
    let is_conditional = second & 0x5000 == 0;
    if is_conditional {
        let is_other = first >> 7 & 7 == 7;
        let high = i64::from(first & 0x3F);
        let offset = j2 << 19 | j1 << 18 | high << 12 | low << 1;
        return (!is_other).then_some(offset - (sign << 20));
    }
    let is_branch = second & 0x1000 != 0;
    let (i1, i2) = (1 - (j1 ^ sign), 1 - (j2 ^ sign));
    let high = i64::from(first & 0x3FF);
    let offset = i1 << 23 | i2 << 22 | high << 12 | low << 1;
    is_branch.then_some(offset - (sign << 24))
}

/// B, and B with a condition.
fn short_branch(half: u16) -> Option<i64> {
    let low = i64::from(half);
    match half >> 12 {
        0b1110 if half >> 11 & 1 == 0 => Some((low & 0x3FF) * 2 - (low & 0x400) * 2),
        0b1101 if half >> 8 & 0xF < 0b1110 => Some((low & 0x7F) * 2 - (low & 0x80) * 2),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As `llvm-mc --triple=thumbv7em --show-encoding` writes them.
    #[test]
    fn branches_lead_where_the_assembler_meant() {
        for (name, code, to) in [
            ("bl #0x1000", &[0x01, 0xF0, 0x00, 0xF8][..], Some(0x1004)),
            ("bl #-4", &[0xFF, 0xF7, 0xFE, 0xFF], Some(0x0)),
            ("b.w #0x123456", &[0x23, 0xF1, 0x2B, 0xBA], Some(0x12_345A)),
            ("beq.w #0x800", &[0x00, 0xF0, 0x00, 0x84], Some(0x804)),
            ("b #0x7FE", &[0xFF, 0xE3], Some(0x802)),
            ("bne #0x10", &[0x08, 0xD1], Some(0x14)),
            ("udf #0", &[0x00, 0xDE], None),
            ("svc #0", &[0x00, 0xDF], None),
            ("mov.w r0, #1", &[0x4F, 0xF0, 0x01, 0x00], None),
            ("dmb sy", &[0xBF, 0xF3, 0x5F, 0x8F], None),
            ("blx r3", &[0x98, 0x47], None),
        ] {
            let expected: Vec<Call> = to.map(|to| Call { at: 0, to }).into_iter().collect();
            assert_eq!(calls(code, 0, |_| true), expected, "{name}");
        }
        assert_eq!(calls(&[0x00, 0xBF, 0xFF, 0xE3], 0, |at| at == 0), []);
    }
}
