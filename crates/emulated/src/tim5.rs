//! TIM5, the time base of the firmware.
//!
//! A counter that stands compares nothing: neither setting it up nor a software update (EGR.UG)
//! raises a channel flag, whatever CCRx holds (RM0090 18.4.6: UG reinitialises the counter and
//! updates the registers; 18.4.5: CCxIF is set when the counter *matches*). The model of `rigless`
//! 0.4 raises CCxIF of every channel whose CCRx equals the standing count, which shifts a driver
//! that counts half periods by one. Everything else is that model's.
use rigless::device::{Device, DeviceContext, RegisterFile, RequestChange};
use rigless::soc::RegisterSpec;
use rigless::soc::stm32f427::generated::tim2::{Register, cr1, sr};
use rigless::soc::stm32f427::peripherals::rcc::HSI_HZ;
use rigless::soc::stm32f427::peripherals::tim::{Counter, General, Tim};
use rigless::time::{EventId, VirtualNanos};

/// The 32-bit timer.
#[derive(Debug)]
pub(crate) struct Tim5(Tim<General>);

impl Tim5 {
    /// Out of reset, on the internal oscillator.
    pub(crate) fn new() -> Self {
        Self(Tim::with_clock(HSI_HZ, Counter::Wide))
    }
}

/// The four compare flags, and the bits of EGR that raise them by software.
const COMPARE_FLAGS: u64 =
    sr::CC1IF.mask() | sr::CC2IF.mask() | sr::CC3IF.mask() | sr::CC4IF.mask();

impl Device for Tim5 {
    type Register = Register;

    fn layout(&self) -> &'static [RegisterSpec] {
        Device::layout(&self.0)
    }

    fn read(
        &mut self,
        register: Register,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> Option<u64> {
        Device::read(&mut self.0, register, registers, context)
    }

    fn peek(&self, register: Register, registers: &RegisterFile, now: VirtualNanos) -> Option<u64> {
        Device::peek(&self.0, register, registers, now)
    }

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let before = registers.get(Register::Sr) & COMPARE_FLAGS;
        Device::write(&mut self.0, register, value, registers, context);
        let stands = !cr1::CEN.is_set(registers.get(Register::Cr1));
        let asked = if register == Register::Egr { value & COMPARE_FLAGS } else { 0 };
        let raised = registers.get(Register::Sr) & COMPARE_FLAGS & !before & !asked;
        if stands && raised != 0 {
            registers.write_over_bus(Register::Sr, !raised);
            Device::write(&mut self.0, Register::Sr, !raised, registers, context);
        }
    }

    fn on_event(
        &mut self,
        event: EventId,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        Device::on_event(&mut self.0, event, registers, context);
    }

    fn on_request(
        &mut self,
        request: RequestChange,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        Device::on_request(&mut self.0, request, registers, context);
    }

    fn on_clock(&mut self, hz: u64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        Device::on_clock(&mut self.0, hz, registers, context);
    }

    fn reset(&mut self) {
        Device::reset(&mut self.0);
    }

    fn reset_line(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        Device::reset_line(&mut self.0, registers, context);
    }
}
