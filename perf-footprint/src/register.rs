//! Registers of the controller.

#[expect(unsafe_code, reason = "a register, which is always there")]
pub(crate) fn read(register: usize) -> u32 {
    unsafe { (register as *const u32).read_volatile() }
}

#[expect(unsafe_code, reason = "a register, which is always there")]
pub(crate) fn write(register: usize, value: u32) {
    unsafe { (register as *mut u32).write_volatile(value) }
}
