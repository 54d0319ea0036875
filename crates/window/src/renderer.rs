//! The thread that renders.

use super::mailbox::{Mailbox, State};
use super::render_thread::{Closed, RenderThread};
use direkt::error::GpuError;
use direkt::low_level::gpu::Context;
use std::sync::Arc;
use std::thread::JoinHandle;

/// Losses without an opened device between after which there is no point in another try.
const PATIENCE: u32 = 3;

/// Starts the thread; it ends when the mailbox is told to.
pub fn start(mailbox: Arc<Mailbox>, adapter: Option<String>) -> std::io::Result<JoinHandle<()>> {
    std::thread::Builder::new()
        .name("renderer".to_owned())
        .spawn(move || run(&mailbox, || Context::new(adapter.as_deref())))
}

/// Works off requests on devices that `open` gives: when one is lost, the next goes on with what
/// was saved.
fn run(mailbox: &Mailbox, open: impl Fn() -> Result<Context, GpuError>) {
    let mut runs = 0;
    let mut rescued = Vec::new();
    let mut losses = 0;
    while losses < PATIENCE {
        let context = match open() {
            Ok(context) => context,
            Err(error) => {
                let message = error.to_string();
                mailbox.tell(|status| status.state = State::Failed(message));
                return;
            }
        };
        let facts = context.adapter.clone();
        mailbox.tell(|status| status.adapter = Some(facts));
        let mut render_thread = RenderThread::new(&context, mailbox, &mut runs, rescued);
        match render_thread.run() {
            Closed::Quit => return,
            Closed::Lost(error) => {
                rescued = render_thread.rescue();
                losses = if rescued.is_empty() { losses + 1 } else { 0 };
                let message = format!("{error}; going on with another device");
                mailbox.tell(|status| status.state = State::Failed(message));
            }
        }
    }
}
