//! SPI1 with the encoder's line on it.
//!
//! The encoder lives in the world and knows clock edges, not SPI words. This wrapper tells its end
//! of the line how long a clock period is, and stops the run when the firmware clocks the line in
//! a way no SSI encoder understands.
use std::sync::{Arc, Mutex, PoisonError};

use rigless::chip::{Timeline, spi};
use rigless::device::{Device, DeviceContext, RegisterFile, RequestChange};
use rigless::snapshot::Store;
use rigless::soc::stm32f427::generated::spi1::{Register, cr1};
use rigless::soc::stm32f427::peripherals::rcc::HSI_HZ;
use rigless::soc::stm32f427::peripherals::spi::Spi;
use rigless::time::{EventId, VirtualNanos};
use world::Surroundings;

const NANOS_PER_SECOND: u64 = 1_000_000_000;

/// The serial interface.
#[derive(Debug)]
pub(crate) struct SsiPort {
    inner: Spi,
    clock_hz: u64,
}

impl SsiPort {
    /// Out of reset, with nothing on its wires.
    pub(crate) fn new() -> Self {
        Self { inner: Spi::with_clock(HSI_HZ), clock_hz: HSI_HZ }
    }

    /// Wires the encoder of `surroundings` to it.
    pub(crate) fn attach(&mut self, surroundings: Arc<Mutex<Surroundings>>) {
        self.inner.attach(EncoderLine { surroundings, period_ns: 0 });
    }

    /// Takes the wires off `from`.
    pub(crate) fn inherit(&mut self, from: &mut Self) {
        self.inner.inherit(&mut from.inner);
    }

    fn follow(&mut self, registers: &RegisterFile, context: &mut DeviceContext<'_>) {
        let control = registers.get(Register::Cr1);
        let Some(line) = self.inner.chip_mut::<EncoderLine>(0) else {
            return;
        };
        let divider = 2_u64 << cr1::BR.get(control);
        line.period_ns = NANOS_PER_SECOND * divider / self.clock_hz.max(1);
        if cr1::SPE.is_set(control) && (!cr1::CPOL.is_set(control) || cr1::LSBFIRST.is_set(control))
        {
            context.tell("CR1", "the encoder's clock idles high and its word starts with the MSB");
        }
    }
}

impl Device for SsiPort {
    type Register = Register;

    fn read(
        &mut self,
        register: Register,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> Option<u64> {
        Device::read(&mut self.inner, register, registers, context)
    }

    fn peek(&self, register: Register, registers: &RegisterFile, now: VirtualNanos) -> Option<u64> {
        Device::peek(&self.inner, register, registers, now)
    }

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        Device::write(&mut self.inner, register, value, registers, context);
        if register == Register::Cr1 {
            self.follow(registers, context);
        }
    }

    fn on_event(
        &mut self,
        event: EventId,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        Device::on_event(&mut self.inner, event, registers, context);
    }

    fn on_request(
        &mut self,
        request: RequestChange,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        Device::on_request(&mut self.inner, request, registers, context);
    }

    fn on_clock(&mut self, hz: u64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.clock_hz = hz;
        Device::on_clock(&mut self.inner, hz, registers, context);
        self.follow(registers, context);
    }

    fn reset(&mut self) {
        Device::reset(&mut self.inner);
    }

    fn reset_line(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        Device::reset_line(&mut self.inner, registers, context);
    }
}

/// The encoder's end of the line.
#[derive(Debug)]
struct EncoderLine {
    surroundings: Arc<Mutex<Surroundings>>,
    period_ns: u64,
}

impl Store for EncoderLine {}

impl spi::Peer for EncoderLine {
    /// A word crosses when its last bit has: its first clock edge lies `bits` periods back.
    fn transfer(&mut self, _mosi: u32, bits: u8, context: &mut Timeline<'_, '_>) -> u32 {
        let began = context.now().0.saturating_sub(u64::from(bits) * self.period_ns);
        let mut surroundings = self.surroundings.lock().unwrap_or_else(PoisonError::into_inner);
        let Surroundings { encoder, spindle, .. } = &mut *surroundings;
        encoder.clock(began, spindle, bits, self.period_ns)
    }
}
