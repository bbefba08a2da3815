use crate::Server;

/// The checksum as CiA 301 writes it: a shift register over the bits.
pub(crate) fn checksum(value: &[u8]) -> u16 {
    let mut register = 0_u32;
    for &byte in value.iter().chain(&[0, 0]) {
        for bit in (0..8).rev() {
            register = register << 1 | u32::from(byte >> bit & 1);
            if register & 1 << 16 != 0 {
                register ^= 0x1_1021;
            }
        }
    }
    register as u16
}

/// Reads a value in blocks of `block_len` segments. Of every block the client keeps what `keep`
/// says, and asks for the rest again.
pub(crate) fn upload(
    server: &mut Server,
    index: u16,
    block_len: u8,
    mut keep: impl FnMut(usize) -> usize,
) -> Vec<u8> {
    let [low, high] = index.to_le_bytes();
    let [0xC6, l, h, 0, size @ ..] = server.answer([0xA4, low, high, 0, block_len, 0, 0, 0]) else {
        panic!("not initiated")
    };
    assert_eq!([l, h], [low, high]);
    let size = u32::from_le_bytes(size) as usize;
    let mut value: Vec<u8> = Vec::new();
    let mut segments = server.ask([0xA3, 0, 0, 0, 0, 0, 0, 0]);
    loop {
        assert!(segments.len() <= usize::from(block_len));
        let kept = keep(segments.len()).min(segments.len());
        let mut complete = false;
        for (number, [command, data @ ..]) in (1..).zip(segments.iter().take(kept)) {
            assert_eq!(command & 0x7F, number);
            complete = command & 0x80 != 0;
            value.extend(data);
        }
        let answers = server.ask([0xA2, kept as u8, block_len, 0, 0, 0, 0, 0]);
        if !complete {
            segments = answers;
            continue;
        }
        let [[command, crc_low, crc_high, 0, 0, 0, 0, 0]] = answers[..] else {
            panic!("{answers:02X?}")
        };
        assert_eq!(command & 0xE3, 0xC1);
        value.truncate(value.len() - usize::from(command >> 2 & 7));
        assert_eq!((value.len(), [crc_low, crc_high]), (size, checksum(&value).to_le_bytes()));
        assert_eq!(server.ask([0xA1, 0, 0, 0, 0, 0, 0, 0]), [[0; 8]; 0]);
        return value;
    }
}

/// The frame that begins a download of `size` bytes with a checksum.
pub(crate) fn begin(index: u16, size: u32) -> [u8; 8] {
    let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), size.to_le_bytes());
    [0xC6, low, high, 0, a, b, c, d]
}

/// The segments of a value, from number 1.
pub(crate) fn segments(value: &[u8]) -> Vec<[u8; 8]> {
    let count = value.len().div_ceil(7);
    let mut frames = Vec::new();
    for (number, chunk) in (1..).zip(value.chunks(7)) {
        let mut frame = [0; 8];
        let [command, data @ ..] = &mut frame;
        *command = if usize::from(number) == count { number | 0x80 } else { number };
        data.iter_mut().zip(chunk).for_each(|(place, &byte)| *place = byte);
        frames.push(frame);
    }
    frames
}

/// The frame that ends the download of a value.
pub(crate) fn end(value: &[u8]) -> [u8; 8] {
    let unused = (value.len().div_ceil(7) * 7 - value.len()) as u8;
    let [low, high] = checksum(value).to_le_bytes();
    [0xC1 | unused << 2, low, high, 0, 0, 0, 0, 0]
}
