//! The thread that renders.

use super::mailbox::{Mailbox, State};
use super::studio::{Closed, Studio};
use direkt::error::GpuError;
use direkt::gpu::Context;
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

/// Works off jobs on devices that `open` gives: when one is lost, the next goes on with what was saved.
fn run(mailbox: &Mailbox, open: impl Fn() -> Result<Context, GpuError>) {
    let mut runs = 0;
    let mut rescued = Vec::new();
    let mut losses = 0;
    while losses < PATIENCE {
        let context = match open() {
            Ok(context) => context,
            Err(error) => {
                let message = error.to_string();
                mailbox.tell(|news| news.state = State::Failed(message));
                return;
            }
        };
        let facts = context.adapter.clone();
        mailbox.tell(|news| news.adapter = Some(facts));
        let mut studio = Studio::new(&context, mailbox, &mut runs, rescued);
        match studio.run() {
            Closed::Quit => return,
            Closed::Lost(error) => {
                rescued = studio.rescue();
                losses = if rescued.is_empty() { losses + 1 } else { 0 };
                let message = format!("{error}; going on with another device");
                mailbox.tell(|news| news.state = State::Failed(message));
            }
        }
    }
}
