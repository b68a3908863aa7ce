//! The window: assembles its parts and forwards keys, dropped files and reports.

use std::path::PathBuf;

use eframe::egui::{CentralPanel, ColorImage, Context, Event, Frame, Panel, Ui, ViewportCommand};
use eframe::{App, CreationContext};

use crate::commands::{self, act, catch_up, open_any};
use crate::gpu::host::Gpu;
use crate::gpu::screen;
use crate::recent::Recent;
use crate::session::Session;
use crate::state::keys::{Action, action};
use crate::ui::empty::Beginning;
use crate::ui::{canvas, drop, empty, help, panel, prompt, status, theme, toolbar};

/// The program's window.
pub(crate) struct Viewer {
    pub(crate) session: Session,
    title: String,
}

impl Viewer {
    /// Builds the window's contents and opens the files, if any.
    ///
    /// # Errors
    /// If wgpu does not draw the window.
    pub(crate) fn new(
        creation: &CreationContext<'_>,
        files: &[PathBuf],
        reference: Option<&PathBuf>,
    ) -> Result<Self, String> {
        let state = creation.wgpu_render_state.as_ref();
        let state = state.ok_or("the window has no device to denoise on")?;
        theme::apply(&creation.egui_ctx);
        screen::install(state);
        let context = creation.egui_ctx.clone();
        let mut session = Session::new(Gpu::of(state), move || context.request_repaint());
        session.open(files);
        if let Some(reference) = reference {
            session.read_reference(reference);
        }
        Ok(Self { session, title: String::new() })
    }

    /// Loads the list of recent files from this file and keeps it there.
    pub(crate) fn remember_in(&mut self, store: Option<PathBuf>) {
        self.session.recent = Recent::kept_in(store, &self.session.desk);
    }

    /// Carries out an action; text that it returns goes to the clipboard.
    fn act(&mut self, context: &Context, action: Action) {
        if let Some(text) = act(&mut self.session, action) {
            context.copy_text(text);
        }
    }

    /// Carries out pressed keys, unless the user is typing text.
    fn keys(&mut self, context: &Context) {
        if context.egui_wants_keyboard_input() || self.session.prompt.is_some() {
            return;
        }
        let asked: Vec<_> = context.input(|input| {
            let asked = input.events.iter().filter_map(|event| match event {
                Event::Key { key, pressed: true, modifiers, .. } => action(*key, *modifiers),
                Event::Copy => Some(Action::CopyImage),
                _ => None,
            });
            asked.collect()
        });
        for action in asked {
            self.act(context, action);
        }
    }

    /// Opens dropped files or takes dropped weights; with Shift held, the first file becomes the
    /// reference.
    fn dropped(&mut self, context: &Context) {
        let (paths, shift) = context.input(|input| {
            let dropped = input.raw.dropped_files.iter();
            let paths: Vec<_> = dropped.map(|file| file.path().to_path_buf()).collect();
            (paths, input.modifiers.shift)
        });
        open_any(&mut self.session, &paths, shift);
    }

    /// Processes the threads' reports.
    fn reports(&mut self, context: &Context) {
        catch_up(&mut self.session);
        if let Some(pixels) = self.session.copied.take() {
            let size = pixels.size.map(|side| side as usize);
            context.copy_image(ColorImage::from_rgb(size, pixels.rgb.as_flattened()));
        }
    }

    /// Puts the file's name in the window title.
    fn name(&mut self, context: &Context) {
        let opened = self.session.opened();
        let title = opened.map_or("wgdenoise".into(), |o| format!("{} – wgdenoise", o.name()));
        if title != self.title {
            context.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// Hides the window as soon as it is closed, while running work finishes.
    fn close(context: &Context) {
        if context.input(|input| input.viewport().close_requested()) {
            context.send_viewport_cmd(ViewportCommand::Visible(false));
        }
    }

    fn begin(&mut self, context: &Context, beginning: Beginning) {
        match beginning {
            Beginning::Do(action) => self.act(context, action),
            Beginning::Open(path) => self.session.open(&[path]),
        }
    }
}

impl App for Viewer {
    fn logic(&mut self, context: &Context, _: &mut eframe::Frame) {
        self.keys(context);
        self.dropped(context);
        self.reports(context);
        self.name(context);
        Self::close(context);
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        let session = &mut self.session;
        let mut asked = Panel::top("toolbar").show(ui, |ui| toolbar::show(ui, session)).inner;
        asked = Panel::bottom("status").show(ui, |ui| status::show(ui, session)).inner.or(asked);
        let mut beginning = None;
        if session.loaded.is_some() {
            let column =
                Panel::right("panel").exact_size(300.0).show(ui, |ui| panel::show(ui, session));
            asked = column.inner.or(asked);
            CentralPanel::default().frame(Frame::NONE).show(ui, |ui| canvas::show(ui, session));
        } else {
            beginning = CentralPanel::default().show(ui, |ui| empty::show(ui, session)).inner;
        }
        help::show(&context, &mut session.shows_help);
        drop::show(&context);
        if let Some((purpose, path)) = prompt::show(&context, session) {
            commands::typed(session, purpose, path);
        }
        if let Some(action) = asked {
            self.act(&context, action);
            // The next frame handles the consequences.
            context.request_repaint();
        }
        if let Some(beginning) = beginning {
            self.begin(&context, beginning);
        }
    }
}
