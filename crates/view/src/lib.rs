//! The program `wgdenoise-view`: shows a render noisy and denoised.
//!
//! `state` decides what the window shows and does, as plain values. `work` opens and denoises files
//! on threads of their own, on the window's device (`gpu`). `session` holds everything that is
//! open, `commands` carries out the user's actions, and `ui` draws.

mod app;
mod args;
mod commands;
mod compare;
mod denoise;
mod dialog;
mod further;
mod gpu;
mod images;
mod networks;
mod open;
mod opening;
mod perceived;
mod perceiving;
mod picture;
mod recent;
mod save;
mod session;
mod state;
mod ui;
mod watch;
mod work;

#[cfg(test)]
mod window_test;

use std::process::ExitCode;

use clap::Parser as _;
use eframe::egui::ViewportBuilder;
use eframe::{NativeOptions, Renderer};

/// Opens the window with the files named on the command line.
#[must_use]
pub fn main() -> ExitCode {
    let args = args::Args::parse();
    dialog::listen();
    let options = NativeOptions {
        viewport: ViewportBuilder::default()
            .with_app_id("wgdenoise-view")
            .with_inner_size([1400.0, 900.0])
            .with_min_inner_size([640.0, 420.0]),
        renderer: Renderer::Wgpu,
        wgpu_options: gpu::host::configuration(),
        ..NativeOptions::default()
    };
    let shown = eframe::run_native(
        "wgdenoise",
        options,
        Box::new(move |creation| {
            let mut viewer = app::Viewer::new(creation, &args.files, args.reference.as_ref())?;
            viewer.remember_in(recent::store_of_user());
            Ok(Box::new(viewer))
        }),
    );
    match shown {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("wgdenoise-view: the window cannot be opened: {error}");
            ExitCode::FAILURE
        }
    }
}
