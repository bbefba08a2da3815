use embassy_sync::waitqueue::AtomicWaker;
static CORE: AtomicWaker = AtomicWaker::new();
pub(crate) fn wake() {
    CORE.wake();
}
