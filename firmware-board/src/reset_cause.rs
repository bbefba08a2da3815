//! Why the controller started (RM0090 section 6.3.21, `RCC_CSR`).
use embassy_stm32::pac::RCC;

/// The reasons of the last start. Several can be set; the most telling one comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub(crate) enum ResetCause {
    /// The independent watchdog was not served.
    Watchdog,
    /// The program asked for it.
    Software,
    /// Supply came back after a dip.
    BrownOut,
    /// Supply was switched on.
    PowerOn,
    /// The reset line, by a debugger or the button.
    Pin,
    /// Window watchdog or low-power management; not used by the firmware.
    Other,
}

impl ResetCause {
    /// Reads the cause and clears the flags, so that the next start reports its own.
    #[must_use]
    pub(crate) fn take() -> Self {
        let flags = RCC.csr().read();
        RCC.csr().modify(|w| w.set_rmvf(true));
        // Power-on also sets the brown-out flag, and every reset pulls the reset line.
        if flags.wdgrstf() {
            Self::Watchdog
        } else if flags.sftrstf() {
            Self::Software
        } else if flags.porrstf() {
            Self::PowerOn
        } else if flags.borrstf() {
            Self::BrownOut
        } else if flags.wwdgrstf() || flags.lpwrrstf() {
            Self::Other
        } else {
            Self::Pin
        }
    }
}
