//! Minimal devices and missing adapters.

use wgdenoise::{Denoiser, Gpu, Inputs, KernelSet, Options, wgpu};

use crate::support::{frame, images, run, same_bits, tiny};
use wgdenoise_testing::gpu::gpu;

#[test]
fn a_device_without_features_and_with_default_limits_will_do() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default())).unwrap();
    let plain = wgpu::DeviceDescriptor::default();
    let (device, queue) = pollster::block_on(adapter.request_device(&plain)).unwrap();
    assert_eq!(KernelSet::Auto.resolve(&device), KernelSet::Tiled);
    let images = images(40, 30);
    let frame = frame(&images, Inputs::ALL);
    let denoiser = Denoiser::new(&device, &queue, &tiny(), &Options::default()).unwrap();
    let found = denoiser.denoise(&frame).unwrap();
    same_bits(&found, &run(&Options::default().kernels(KernelSet::Tiled), &frame)).unwrap();
    for (kernels, feature) in [(KernelSet::Simd, "SUBGROUP"), (KernelSet::Half, "SHADER_F16")] {
        let options = Options::default().kernels(kernels);
        let error = Denoiser::new(&device, &queue, &tiny(), &options).unwrap_err().to_string();
        assert!(error.contains(&format!("the feature {feature}; choose Auto")), "{error}");
    }
}

#[test]
fn an_unknown_adapter_is_an_error_that_says_what_there_is() {
    let error = Gpu::open(Some("no such adapter")).unwrap_err().to_string();
    assert!(error.contains(&gpu().info.name) && error.contains("mesa-vulkan-drivers"), "{error}");
}

/// Runs this test binary again with no driver for the Vulkan loader to find.
#[cfg(target_os = "linux")]
#[test]
fn without_an_adapter_the_tests_fail_instead_of_being_skipped() {
    let binary = std::env::current_exe().expect("the binary that runs");
    let output = std::process::Command::new(binary)
        .args(["whole::the_same_input_makes_the_same_bits_every_time", "--exact"])
        .envs(["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].map(|key| (key, "/nonexistent")))
        .output()
        .expect("it runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && text.contains("the tests need an adapter"), "{text}");
}
