//! The scene in a window, with mouse and keys.

mod orbit;
mod present;
mod screen;
mod stopwatch;
mod viewer;

use std::sync::Arc;

use winit::application::ApplicationHandler;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::keyboard::{Key, NamedKey};
use winit::window::{Window, WindowId};

use self::present::Split;
use self::screen::Screen;
use self::stopwatch::Times;
use self::viewer::Viewer;
use crate::args::Args;
use crate::renderer::Result;

/// What the user sees and does.
struct App<'a> {
    args: &'a Args,
    /// None until the event loop says that windows can be made.
    open: Option<(Arc<Window>, Viewer)>,
    controls: Controls,
    /// Why the event loop was left, if not by the user.
    failure: Option<Box<dyn std::error::Error>>,
}

/// The state of mouse and keys.
struct Controls {
    denoise: bool,
    /// Where the divider is, as a share of the width, if there is one.
    divider: Option<f32>,
    mouse: [f32; 2],
    drag: Option<Drag>,
}

/// What the pressed mouse moves.
#[derive(Clone, Copy, PartialEq)]
enum Drag {
    Camera,
    Divider,
}

/// How near to the divider the mouse grasps it, in pixels.
const GRASP: f32 = 12.0;

/// Pixels of a touchpad's scrolling that count as a step of a wheel.
const WHEEL_STEP: f32 = 40.0;

/// Opens a window, and returns when it is closed.
///
/// # Errors
/// If there is no display or no adapter for it, or the device fails.
pub(crate) fn run(args: &Args) -> Result<()> {
    let controls = Controls { denoise: true, divider: None, mouse: [0.0; 2], drag: None };
    let mut app = App { args, open: None, controls, failure: None };
    EventLoop::new()?.run_app(&mut app)?;
    app.failure.map_or(Ok(()), Err)
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.is_none() {
            let opened = self.open(event_loop);
            self.stop_on_failure(event_loop, opened);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let result = match event {
            WindowEvent::CloseRequested => {
                event_loop.exit();
                Ok(())
            }
            WindowEvent::RedrawRequested => self.draw(),
            WindowEvent::Resized(size) => self.resize(size),
            WindowEvent::KeyboardInput { event, .. } if event.state == ElementState::Pressed => {
                self.press(event_loop, &event.logical_key);
                Ok(())
            }
            WindowEvent::MouseInput { state, button: MouseButton::Left, .. } => {
                self.grasp(state == ElementState::Pressed);
                Ok(())
            }
            WindowEvent::CursorMoved { position, .. } => {
                self.move_mouse(position);
                Ok(())
            }
            WindowEvent::MouseWheel { delta, .. } => {
                self.zoom(delta);
                Ok(())
            }
            _ => Ok(()),
        };
        self.stop_on_failure(event_loop, result);
    }
}

impl App<'_> {
    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<()> {
        let [width, height] = self.args.size;
        let attributes = Window::default_attributes()
            .with_title("wgdenoise path tracer")
            .with_inner_size(PhysicalSize { width, height });
        let window = Arc::new(event_loop.create_window(attributes)?);
        let display = event_loop.owned_display_handle();
        let screen = Screen::open(display, window.clone(), self.args.device.as_deref())?;
        window.request_redraw();
        self.open = Some((window, Viewer::new(screen, self.args)?));
        Ok(())
    }

    fn stop_on_failure(&mut self, event_loop: &ActiveEventLoop, result: Result<()>) {
        if let Err(error) = result {
            self.failure = Some(error);
            event_loop.exit();
        }
    }

    fn draw(&mut self) -> Result<()> {
        let Some((window, viewer)) = &mut self.open else { return Ok(()) };
        let split = self.controls.split(viewer.width());
        if let Some(times) = viewer.draw(split)? {
            window.set_title(&title(viewer.samples(), times));
        }
        window.request_redraw();
        Ok(())
    }

    /// A window without area, as when it is minimised, keeps its images.
    fn resize(&mut self, size: PhysicalSize<u32>) -> Result<()> {
        let Some((_, viewer)) = &mut self.open else { return Ok(()) };
        if size.width == 0 || size.height == 0 {
            return Ok(());
        }
        viewer.resize([size.width, size.height])
    }

    fn press(&mut self, event_loop: &ActiveEventLoop, key: &Key) {
        match key.as_ref() {
            Key::Named(NamedKey::Escape) => event_loop.exit(),
            Key::Character("d" | "D") => self.controls.denoise = !self.controls.denoise,
            Key::Character("s" | "S") => {
                let shown = self.controls.divider.is_some();
                self.controls.divider = (!shown).then_some(0.5);
            }
            _ => {}
        }
    }

    fn grasp(&mut self, pressed: bool) {
        let Some((_, viewer)) = &self.open else { return };
        let Controls { divider, mouse, .. } = self.controls;
        let near = |share: f32| (share * viewer.width() - mouse[0]).abs() < GRASP;
        let what = if divider.is_some_and(near) { Drag::Divider } else { Drag::Camera };
        self.controls.drag = pressed.then_some(what);
    }

    fn move_mouse(&mut self, position: PhysicalPosition<f64>) {
        let Some((_, viewer)) = &mut self.open else { return };
        let now = [position.x as f32, position.y as f32];
        let before = std::mem::replace(&mut self.controls.mouse, now);
        let moved = [now[0] - before[0], now[1] - before[1]];
        match self.controls.drag {
            Some(Drag::Camera) => viewer.look(|camera| orbit::drag(camera, moved)),
            Some(Drag::Divider) => {
                self.controls.divider = Some((now[0] / viewer.width()).clamp(0.0, 1.0));
            }
            None => {}
        }
    }

    fn zoom(&mut self, delta: MouseScrollDelta) {
        let Some((_, viewer)) = &mut self.open else { return };
        let steps = match delta {
            MouseScrollDelta::LineDelta(_, lines) => lines,
            MouseScrollDelta::PixelDelta(by) => by.y as f32 / WHEEL_STEP,
        };
        viewer.look(|camera| orbit::zoom(camera, steps));
    }
}

impl Controls {
    /// The noisy image ends at the divider; without one it is all that is shown, or nothing.
    fn split(&self, width: f32) -> Split {
        let noisy = if self.denoise { self.divider.unwrap_or(0.0) } else { 1.0 };
        Split { divider: noisy * width, marked: self.denoise && self.divider.is_some() }
    }
}

fn title(samples: u32, times: Times) -> String {
    let ms = |time: std::time::Duration| time.as_secs_f64() * 1e3;
    let times = match times {
        Times::Parts { render, denoise } => {
            format!("render {:.1} ms, denoise {:.1} ms", ms(render), ms(denoise))
        }
        Times::Whole(whole) => format!("frame {:.1} ms", ms(whole)),
    };
    format!("wgdenoise path tracer: {samples} samples, {times}")
}
