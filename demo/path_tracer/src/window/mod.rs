//! Shows a scene in a window while its samples accumulate.

mod controls;
mod orbit;
mod present;
mod screen;
mod stopwatch;
mod viewer;

use std::sync::Arc;
use std::time::Duration;

use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, KeyEvent, MouseButton, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::keyboard::{Key, NamedKey};
use winit::window::{Window, WindowId};

use self::controls::{Controls, steps};
use self::screen::Screen;
use self::stopwatch::Times;
use self::viewer::Viewer;
use crate::args::Args;
use path_tracer::renderer::Result;

/// The window and its contents.
struct App<'a> {
    args: &'a Args,
    /// `None` until the event loop allows windows.
    open: Option<(Arc<Window>, Viewer)>,
    controls: Controls,
    /// The error that ended the event loop, if any.
    failure: Option<Box<dyn std::error::Error>>,
}

/// Opens a window and returns when it is closed.
///
/// # Errors
/// If there is no display, no adapter can draw to it, or the device fails.
pub(crate) fn run(args: &Args) -> Result<()> {
    let mut app = App { args, open: None, controls: Controls::new(args), failure: None };
    let event_loop = EventLoop::new()
        .map_err(|_| "no display to open a window on; use --out FILE to write files instead")?;
    event_loop.run_app(&mut app)?;
    app.failure.map_or(Ok(()), Err)
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.is_none() {
            let opened = self.open(event_loop);
            self.leave_on_failure(event_loop, opened);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let result = self.react(event_loop, event);
        self.leave_on_failure(event_loop, result);
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

    fn leave_on_failure(&mut self, event_loop: &ActiveEventLoop, result: Result<()>) {
        if let Err(error) = result {
            self.failure = Some(error);
            event_loop.exit();
        }
    }

    fn react(&mut self, event_loop: &ActiveEventLoop, event: WindowEvent) -> Result<()> {
        let Some((window, viewer)) = &mut self.open else { return Ok(()) };
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::RedrawRequested => return draw(window, viewer, &self.controls),
            WindowEvent::Resized(size) => return resize(viewer, size),
            WindowEvent::KeyboardInput { event, .. } => match pressed(&event) {
                Some(Key::Named(NamedKey::Escape)) => event_loop.exit(),
                Some(Key::Character(letter)) => self.controls.press(letter),
                _ => {}
            },
            WindowEvent::MouseInput { state, button: MouseButton::Left, .. } => match state {
                ElementState::Pressed => self.controls.grasp(viewer.width()),
                ElementState::Released => self.controls.release(),
            },
            WindowEvent::CursorMoved { position, .. } => {
                let now = [position.x as f32, position.y as f32];
                if let Some(moved) = self.controls.move_to(now, viewer.width()) {
                    viewer.look(|orbit| orbit.drag(moved));
                }
            }
            WindowEvent::MouseWheel { delta, .. } if steps(delta) != 0.0 => {
                viewer.look(|orbit| orbit.zoom(steps(delta)));
            }
            _ => {}
        }
        Ok(())
    }
}

/// Draws a frame and requests the next.
fn draw(window: &Window, viewer: &mut Viewer, controls: &Controls) -> Result<()> {
    match viewer.draw(controls)? {
        Some(times) => window.set_title(&title(viewer.samples(), controls.temporal, times)),
        // Do not keep a core busy for a hidden window.
        None => std::thread::sleep(Duration::from_millis(50)),
    }
    window.request_redraw();
    Ok(())
}

/// Resizes the images. A minimized window, which has no area, keeps them.
fn resize(viewer: &mut Viewer, size: PhysicalSize<u32>) -> Result<()> {
    let visible = size.width > 0 && size.height > 0;
    if visible { viewer.resize([size.width, size.height]) } else { Ok(()) }
}

fn pressed(event: &KeyEvent) -> Option<Key<&str>> {
    (event.state == ElementState::Pressed).then(|| event.logical_key.as_ref())
}

fn title(samples: u32, temporal: bool, times: Times) -> String {
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    let times = match times {
        Times::Parts { render, denoise } => {
            format!("render {:.1} ms, denoise {:.1} ms", ms(render), ms(denoise))
        }
        Times::Whole(whole) => format!("frame {:.1} ms", ms(whole)),
    };
    let temporal = if temporal { ", temporal" } else { "" };
    format!("wgdenoise path tracer: {samples} samples{temporal}, {times}")
}
