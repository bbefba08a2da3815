//! A number that tells one start of this controller from the next.
//!
//! It lives in RAM that the start-up code leaves alone, so it counts every reset. A loss of supply
//! begins anew; both controllers share one supply, so there is nobody then who could remember.
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::num::NonZeroU32;

#[repr(C)]
struct Counter {
    starts: u32,
    /// The complement of `starts`, if this is a counter and not what RAM holds after power-on.
    complement: u32,
}

struct Kept(UnsafeCell<MaybeUninit<Counter>>);

#[expect(unsafe_code, reason = "accessed once, before interrupts and tasks run")]
unsafe impl Sync for Kept {}

#[expect(unsafe_code, reason = "the section decides that start-up leaves the counter alone")]
#[unsafe(link_section = ".uninit.start_number")]
static KEPT: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

/// Counts this start. To be called once.
pub(crate) fn count_start() -> NonZeroU32 {
    #[expect(unsafe_code, reason = "nothing else runs yet; every bit pattern is valid")]
    let kept = unsafe { (*KEPT.0.get()).assume_init_mut() };
    let before = if kept.starts == !kept.complement { kept.starts } else { 0 };
    let starts = NonZeroU32::new(before.wrapping_add(1)).unwrap_or(NonZeroU32::MIN);
    *kept = Counter { starts: starts.get(), complement: !starts.get() };
    starts
}
