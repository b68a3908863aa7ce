//! `wgdenoise devices`.

use serde_json::json;

use super::args::DevicesArgs;
use super::failure::Failure;
use super::print;
use wgdenoise::Gpu;
use wgdenoise::wgpu::AdapterInfo;

/// Lists the adapters in the order in which `--adapter` counts them.
pub(super) fn run(args: &DevicesArgs) -> Result<(), Failure> {
    let adapters = Gpu::list();
    if adapters.is_empty() {
        // The engine's own sentence says how to get one.
        Gpu::open(None)?;
    }
    if args.json {
        let list: Vec<_> = adapters.iter().enumerate().map(|(i, a)| as_json(i, a)).collect();
        return print(&serde_json::Value::from(list).to_string());
    }
    let lines: Vec<_> = adapters.iter().enumerate().map(|(i, a)| as_line(i, a)).collect();
    print(&lines.join("\n"))
}

fn as_line(index: usize, adapter: &AdapterInfo) -> String {
    format!(
        "{index}: {} ({:?}, {:?}, {} {})",
        adapter.name, adapter.device_type, adapter.backend, adapter.driver, adapter.driver_info
    )
}

fn as_json(index: usize, adapter: &AdapterInfo) -> serde_json::Value {
    json!({
        "index": index,
        "name": adapter.name,
        "type": format!("{:?}", adapter.device_type),
        "backend": format!("{:?}", adapter.backend),
        "driver": adapter.driver,
        "driver_info": adapter.driver_info,
    })
}
