//! How much of the error can be seen: FLIP between the reference and what the window shows.
//!
//! It depends on the exposure, so it is computed anew when that changes, on a thread of its own.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use wgdenoise::Image;
use wgdenoise_metrics::{PIXELS_PER_DEGREE, flip};

use crate::denoise::Outcome;
use crate::gpu::host::Gpu;
use crate::gpu::screen::Kind;
use crate::gpu::texture::Texture;
use crate::open::Opened;
use crate::session::Session;
use crate::state::looking::{Measure, Shown};
use crate::state::magma::magma;
use crate::state::tone::{Curve, Tone, light_of};
use crate::work::{Desk, Lane, Report};

/// The visible errors of the open image.
pub(crate) struct Perceived {
    /// The mean errors of the noisy and the denoised image, from 0 to 1.
    pub(crate) means: [f64; 2],
    /// The denoised image's errors, row by row.
    pub(crate) errors: Vec<f32>,
    /// The same in colors, as light.
    pub(crate) map: Image,
    pub(crate) texture: Texture,
}

/// Computes errors whenever something they depend on has changed.
pub(crate) struct Perceiving {
    lane: Lane<()>,
    /// The ticket of what was asked for last; older ones are skipped.
    latest: Arc<AtomicU64>,
    asked: Option<Asked>,
    found: Option<Perceived>,
}

/// What errors depend on.
#[derive(Clone)]
struct Asked {
    opened: Arc<Opened>,
    outcome: Arc<Outcome>,
    reference: Arc<Image>,
    exposure: f32,
}

impl Perceiving {
    pub(crate) fn new(desk: Desk) -> Self {
        let lane = Lane::new(desk, || ());
        Self { lane, latest: Arc::default(), asked: None, found: None }
    }

    /// The errors of what is open; `None` until they are computed.
    pub(crate) fn found(&self) -> Option<&Perceived> {
        self.found.as_ref()
    }

    /// Takes errors that were computed, unless they are out of date.
    pub(crate) fn take(&mut self, ticket: u64, found: Perceived) {
        if self.latest.load(Ordering::Relaxed) == ticket {
            self.found = Some(found);
        }
    }
}

/// Starts to compute the errors of what is open, if that has not been done.
pub(crate) fn keep_up(session: &mut Session) {
    let wanted = Asked::of(session);
    let perceiving = &mut session.perceiving;
    let is_asked = match (&wanted, &perceiving.asked) {
        (Some(wanted), Some(asked)) => wanted.is_same(asked),
        (wanted, asked) => wanted.is_none() && asked.is_none(),
    };
    if is_asked {
        return;
    }
    // While only the exposure changes, the map stays.
    let is_other = |asked: &Asked| wanted.as_ref().is_none_or(|w| !w.has_images_of(asked));
    if perceiving.asked.as_ref().is_none_or(is_other) {
        perceiving.found = None;
    }
    perceiving.asked.clone_from(&wanted);
    let ticket = perceiving.latest.fetch_add(1, Ordering::Relaxed) + 1;
    let (latest, gpu) = (perceiving.latest.clone(), session.gpu.clone());
    let Some(wanted) = wanted else { return };
    perceiving.lane.add(move |()| {
        let is_latest = latest.load(Ordering::Relaxed) == ticket;
        let found = is_latest.then(|| wanted.compute(&gpu));
        found.map_or(Report::Nothing, |found| Report::Perceived(ticket, found))
    });
}

impl Session {
    /// The visible errors, if a difference shows them.
    pub(crate) fn perceived(&self) -> Option<&Perceived> {
        self.perceiving.found().filter(|_| self.looking.measure == Measure::Perceived)
    }

    /// How the values of an image are to be read.
    pub(crate) fn kind(&self, shown: Shown) -> Kind {
        match shown {
            Shown::Noisy | Shown::Denoised | Shown::Reference => Kind::Light,
            Shown::Albedo => Kind::Surface,
            Shown::Normal => Kind::Direction,
            Shown::Difference if self.perceived().is_some() => Kind::Surface,
            Shown::Difference => Kind::Difference,
        }
    }
}

impl Asked {
    /// What is open, if there are a result and a reference of its size.
    fn of(session: &Session) -> Option<Self> {
        let reference = session.reference.as_ref().filter(|_| session.available().reference)?;
        Some(Self {
            opened: session.opened()?.clone(),
            outcome: session.denoised.as_ref()?.outcome.clone(),
            reference: reference.image.clone(),
            exposure: session.tone.exposure,
        })
    }

    fn is_same(&self, other: &Self) -> bool {
        self.exposure == other.exposure && self.has_images_of(other)
    }

    fn has_images_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.opened, &other.opened)
            && Arc::ptr_eq(&self.outcome, &other.outcome)
            && Arc::ptr_eq(&self.reference, &other.reference)
    }

    fn compute(&self, gpu: &Gpu) -> Result<Perceived, String> {
        let tone = Tone { exposure: self.exposure, curve: Curve::Srgb };
        let reference = displayed(&self.reference, tone)?;
        let error = |image: &Image| {
            let found = flip(&displayed(image, tone)?, &reference, PIXELS_PER_DEGREE);
            found.map_err(|error| error.to_string())
        };
        let noisy = error(self.opened.view().color())?;
        let denoised = error(&self.outcome.results[self.opened.shown].color)?;
        let colors = denoised.errors.iter().map(|&error| magma(error).map(light_of)).collect();
        let map = image(&self.reference, colors)?;
        let texture = Texture::upload(gpu, &map)?;
        let means = [noisy.mean, denoised.mean];
        Ok(Perceived { means, errors: denoised.errors, map, texture })
    }
}

/// The values of the screen.
fn displayed(light: &Image, tone: Tone) -> Result<Image, String> {
    image(light, light.pixels().iter().map(|pixel| tone.screen(*pixel)).collect())
}

/// An image of the same size as another.
fn image(like: &Image, pixels: Vec<[f32; 3]>) -> Result<Image, String> {
    Image::new(like.width(), like.height(), pixels).map_err(|error| error.to_string())
}
