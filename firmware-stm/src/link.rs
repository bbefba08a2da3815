//! The application controller's bytes, from the ring of the link port to the core.
use embassy_time::with_timeout;
use firmware_board::{Beat, LinkReceiver, SHOW_UP_EVERY};
use heapless::spsc::Producer;

use crate::core_task;

/// Bytes taken out of the ring at once.
const CHUNK_LEN: usize = 64;

/// The link's task is alive.
pub(crate) static BEAT: Beat = Beat::new();

/// Hands on what comes from the line. Damaged bytes are the core's to find: every frame carries its
/// check sum.
pub(crate) async fn receive(mut port: LinkReceiver, mut to_core: Producer<'static, u8>) -> ! {
    let mut chunk = [0; CHUNK_LEN];
    loop {
        // Reading out of a ring: giving up loses nothing.
        if let Ok(Ok(len)) = with_timeout(SHOW_UP_EVERY, port.read(&mut chunk)).await {
            for byte in chunk.iter().take(len) {
                // The core runs above this task and empties the queue; it cannot be full.
                let _ = to_core.enqueue(*byte);
            }
            core_task::wake();
        }
        BEAT.show();
    }
}
