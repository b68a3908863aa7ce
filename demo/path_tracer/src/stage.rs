//! A scene in motion, frame by frame.

use crate::renderer::camera::Camera;
use crate::renderer::film::Film;
use crate::renderer::motion::Motion;
use crate::renderer::scenes::{PERIOD, SceneName};
use crate::renderer::{Kernels, Method, Renderer, Result};

/// What changes from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Seconds since the spheres began to move.
    pub time: f32,
    /// The view.
    pub camera: Camera,
}

impl Moment {
    /// The next frame's moment, 1/30 s later: the camera orbits the scene by this angle, in
    /// degrees, and the spheres move if animated.
    #[must_use]
    pub fn next(self, orbit: f32, animate: bool) -> Self {
        let step = if animate { FRAME } else { 0.0 };
        Self { time: (self.time + step) % PERIOD, camera: self.camera.orbit(orbit) }
    }
}

/// Seconds between the frames of an animation.
const FRAME: f32 = 1.0 / 30.0;

/// A built-in scene that remembers the last frame.
pub struct Stage {
    /// Draws the scene as it is now.
    pub renderer: Renderer,
    name: SceneName,
    now: Moment,
    last: Moment,
}

impl Stage {
    /// Builds the scene at rest, seen by its own camera.
    #[must_use]
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        kernels: &Kernels,
        name: SceneName,
    ) -> Self {
        let scene = name.build();
        let renderer = Renderer::new(device, queue, kernels, &scene, Method::default());
        let now = Moment { time: 0.0, camera: scene.camera };
        Self { renderer, name, now, last: now }
    }

    /// The current frame's moment.
    #[must_use]
    pub fn now(&self) -> Moment {
        self.now
    }

    /// Begins the next frame. If it differs from the last one, the film starts over.
    ///
    /// # Errors
    /// None for built-in scenes: their shapes move, but their number stays the same.
    pub fn show(&mut self, moment: Moment, film: &mut Film) -> Result<()> {
        let moved = self.last.time != self.now.time;
        self.last = std::mem::replace(&mut self.now, moment);
        let [now, last] = [self.now.time, self.last.time];
        // Shapes that have just stopped still carry their motion.
        if moved || now != last {
            self.renderer.update(&self.name.at(now), &self.name.at(last))?;
        }
        if self.now != self.last {
            film.start_over();
        }
        Ok(())
    }

    /// Records more samples of this frame, as [`Renderer::encode`] does.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        film: &mut Film,
        samples: u32,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        self.renderer.encode(encoder, film, &self.now.camera, samples, timestamp_writes);
    }

    /// Records motion vectors from this frame to the last one.
    pub fn encode_motion(&self, encoder: &mut wgpu::CommandEncoder, motion: &Motion) {
        self.renderer.encode_motion(encoder, motion, [&self.now.camera, &self.last.camera]);
    }
}
