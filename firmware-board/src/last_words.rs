//! What the program said before it stopped, kept over the reset.
//!
//! A panic or a fault has to leave the outputs safe and restart at once, with nobody there to read
//! a message. So the text goes into RAM that the start-up code does not touch, and the next start
//! logs it. Writing the log at the time of the panic is no alternative: the panic may come from
//! within the logger.
use core::cell::UnsafeCell;
use core::fmt::{Arguments, Write};
use core::mem::MaybeUninit;

use cortex_m_rt::ExceptionFrame;

const TEXT_LEN: usize = 160;
/// Marks a text written by [`stop`]; RAM after power-on holds it by chance once in 2^32 starts.
const WRITTEN: u32 = 0x1A57_F0E5;

#[repr(C)]
struct LastWords {
    mark: u32,
    len: usize,
    text: [u8; TEXT_LEN],
}

struct Kept(UnsafeCell<MaybeUninit<LastWords>>);

#[expect(unsafe_code, reason = "accessed before interrupts run and after they are switched off")]
unsafe impl Sync for Kept {}

#[expect(unsafe_code, reason = "the section decides that start-up leaves the text alone")]
#[unsafe(link_section = ".uninit.last_words")]
static KEPT: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

impl Write for LastWords {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for (place, byte) in self.text.iter_mut().skip(self.len).zip(text.bytes()) {
            // One line in the log.
            *place = if byte == b'\n' { b' ' } else { byte };
            self.len += 1;
        }
        Ok(())
    }
}

/// Logs what the last run left behind, once. To be called first thing after start.
pub(crate) fn report_last_words() {
    #[expect(
        unsafe_code,
        reason = "nothing else runs yet; every bit pattern of the three fields is valid"
    )]
    let kept = unsafe { (*KEPT.0.get()).assume_init_mut() };
    if kept.mark == WRITTEN {
        kept.mark = 0;
        let text = kept.text.get(..kept.len).unwrap_or(&kept.text);
        defmt::error!("stopped before: {=str}", core::str::from_utf8(text).unwrap_or("?"));
    }
}

/// Keeps `words` for the next start and resets the controller.
///
/// The caller has already brought the outputs to their safe state.
pub fn stop(words: Arguments<'_>) -> ! {
    cortex_m::interrupt::disable();
    #[expect(unsafe_code, reason = "interrupts are off and this function does not return")]
    let kept =
        unsafe { (*KEPT.0.get()).write(LastWords { mark: WRITTEN, len: 0, text: [0; TEXT_LEN] }) };
    // Truncation is no error of `LastWords`; what a `Display` returns changes nothing any more.
    let _ = kept.write_fmt(words);
    cortex_m::asm::dsb();
    cortex_m::peripheral::SCB::sys_reset()
}

/// [`stop`] with the place and the status of a hard fault (ARM DDI 0403 section B3.2.15).
pub fn stop_on_fault(frame: &ExceptionFrame) -> ! {
    #[expect(unsafe_code, reason = "reads two status registers")]
    let (cfsr, hfsr) = unsafe {
        let scb = &*cortex_m::peripheral::SCB::PTR;
        (scb.cfsr.read(), scb.hfsr.read())
    };
    let (pc, lr) = (frame.pc(), frame.lr());
    stop(format_args!("fault at {pc:#010x} from {lr:#010x}, CFSR {cfsr:#x}, HFSR {hfsr:#x}"))
}
