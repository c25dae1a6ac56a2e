//! A thread beside a streamer that renews plans, so that setpoints go on while a solve is under way.
#![expect(
    clippy::disallowed_types,
    clippy::disallowed_methods,
    reason = "the shell's clock: how long a solve took is measured"
)]

use std::sync::mpsc::{Sender, channel};
use std::time::{Duration, Instant};

use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

use crate::replan::{Renewal, ReplanAnswer, ReplanRequest};

/// The thread's two ends; dropped, the thread ends after the solve that is under way.
#[derive(Debug)]
pub(super) struct Solver {
    requests: Sender<ReplanRequest>,
    answers: UnboundedReceiver<(ReplanAnswer, Duration)>,
}

impl Solver {
    /// Starts the thread.
    pub(super) fn start(mut renewal: Renewal) -> Self {
        let ((requests, asked), (answer, answers)) = (channel::<ReplanRequest>(), unbounded_channel());
        std::thread::spawn(move || {
            for request in asked {
                let began = Instant::now();
                let answered = renewal.answer(&request);
                if answer.send((answered, began.elapsed())).is_err() {
                    break;
                }
            }
        });
        Self { requests, answers }
    }

    /// Has a request solved.
    pub(super) fn ask(&self, request: ReplanRequest) {
        // A thread that is gone leaves the request open: nothing is renewed any more.
        let _ = self.requests.send(request);
    }

    /// The next answer and how long its solve took; of no solver, none ever.
    pub(super) async fn answer(solver: &mut Option<Self>) -> (ReplanAnswer, Duration) {
        if let Some(solver) = solver
            && let Some(answer) = solver.answers.recv().await
        {
            return answer;
        }
        std::future::pending().await
    }
}
