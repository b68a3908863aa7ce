//! Recomputes the visible errors on its own thread whenever the images or the exposure change.

use crate::gpu::host::Gpu;
use crate::perceived::{Asked, Perceived};
use crate::state::latest::Latest;
use crate::work::{Desk, Lane, Report};

/// Computes errors whenever their inputs have changed.
pub(crate) struct Perceiving {
    lane: Lane<()>,
    latest: Latest,
    asked: Option<Asked>,
    found: Option<Perceived>,
}

impl Perceiving {
    pub(crate) fn new(desk: Desk) -> Self {
        let lane = Lane::new(desk, || ());
        Self { lane, latest: Latest::default(), asked: None, found: None }
    }

    /// The errors of the open image; `None` until they are computed.
    pub(crate) fn found(&self) -> Option<&Perceived> {
        self.found.as_ref()
    }

    /// Takes computed errors, unless they are out of date.
    pub(crate) fn take(&mut self, ticket: u64, found: Perceived) {
        if self.latest.is(ticket) {
            self.found = Some(found);
        }
    }

    /// Starts computing the wanted errors, unless they were already requested.
    pub(crate) fn ask(&mut self, wanted: Option<Asked>, gpu: &Gpu) {
        let is_asked = match (&wanted, &self.asked) {
            (Some(wanted), Some(asked)) => wanted.is_same(asked),
            (wanted, asked) => wanted.is_none() && asked.is_none(),
        };
        if is_asked {
            return;
        }
        // If only the exposure changes, the old map stays until the new one is ready.
        let is_other = |asked: &Asked| wanted.as_ref().is_none_or(|w| !w.has_images_of(asked));
        if self.asked.as_ref().is_none_or(is_other) {
            self.found = None;
        }
        self.asked.clone_from(&wanted);
        let ticket = self.latest.next();
        if let Some(wanted) = wanted {
            self.start(ticket, wanted, gpu.clone());
        }
    }

    fn start(&self, ticket: u64, wanted: Asked, gpu: Gpu) {
        let latest = self.latest.clone();
        self.lane.add(move |()| {
            let found = latest.is(ticket).then(|| wanted.compute(&gpu));
            found.map_or(Report::Nothing, |found| Report::Perceived(ticket, found))
        });
    }
}
