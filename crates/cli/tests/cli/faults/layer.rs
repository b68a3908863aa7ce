//! A Vulkan layer between loader and driver that imitates a broken driver. `mod.rs` compiles and
//! loads it; the program under test is unaware of it.
//!
//! The variable `FAULT` selects the fault. `memory N`: the device has N bytes of memory. `lost N`:
//! the device is lost from the Nth wait on. `hang N`: nothing completes from the Nth submission on.
//! `wrong N`: the Nth dispatch is skipped.
//!
//! The structures follow `vulkan_core.h` and `vk_layer.h`, as far as they are read.
#![allow(unsafe_code, reason = "a layer is a C library")]

use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_void};
use std::mem::transmute;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicPtr, AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, OnceLock};
use std::thread::sleep;
use std::time::Duration;

type Handle = *mut c_void;
type Function = Option<unsafe extern "C" fn()>;
type GetProc = unsafe extern "C" fn(Handle, *const c_char) -> Function;
type Create = unsafe extern "C" fn(Handle, *const Chained, Handle, *mut Handle) -> i32;

const OUT_OF_DEVICE_MEMORY: i32 = -2;
const DEVICE_LOST: i32 = -4;
const LOADER_INSTANCE_CREATE_INFO: u32 = 47;
const LOADER_DEVICE_CREATE_INFO: u32 = 48;

#[repr(C)]
pub struct Negotiation {
    kind: u32,
    next: Handle,
    version: u32,
    get_instance_proc: Option<GetProc>,
    get_device_proc: Option<GetProc>,
    get_physical_device_proc: Option<GetProc>,
}

/// The common start of chained structures, plus the loader's additions.
#[repr(C)]
struct Chained {
    kind: u32,
    next: *mut Chained,
    function: u32,
    link: *mut Link,
}

/// The next layer's functions; an instance's second function is not needed here.
#[repr(C)]
struct Link {
    next: *mut Link,
    get_instance_proc: GetProc,
    get_device_proc: GetProc,
}

#[repr(C)]
struct Allocation {
    kind: u32,
    next: Handle,
    size: u64,
}

static INSTANCE: AtomicPtr<c_void> = AtomicPtr::new(null_mut());
static DEVICE: AtomicPtr<c_void> = AtomicPtr::new(null_mut());
static OF_INSTANCE: OnceLock<GetProc> = OnceLock::new();
static OF_DEVICE: OnceLock<GetProc> = OnceLock::new();

/// Size of each allocation in bytes.
static ALLOCATED: Mutex<Option<HashMap<u64, u64>>> = Mutex::new(None);

/// Number of calls counted by the fault.
static CALLS: AtomicU64 = AtomicU64::new(0);

/// The fault's number, if the fault is of this kind.
fn fault(kind: &str) -> Option<u64> {
    static FAULT: OnceLock<String> = OnceLock::new();
    let fault = FAULT.get_or_init(|| std::env::var("FAULT").unwrap_or_default());
    fault.strip_prefix(kind)?.trim().parse().ok()
}

/// Whether the calls have reached the fault.
fn came_to(kind: &str) -> bool {
    fault(kind).is_some_and(|first| CALLS.load(Relaxed) >= first)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn vkNegotiateLoaderLayerInterfaceVersion(with: *mut Negotiation) -> i32 {
    let with = unsafe { &mut *with };
    with.version = 2;
    with.get_instance_proc = Some(get_instance_proc);
    with.get_device_proc = Some(get_device_proc);
    with.get_physical_device_proc = None;
    0
}

/// Finds a function of the next layer.
unsafe fn below(name: &CStr) -> Function {
    let get = OF_DEVICE.get().expect("there is a device");
    unsafe { get(DEVICE.load(Relaxed), name.as_ptr()) }
}

unsafe fn create(
    kind: u32,
    name: &CStr,
    [parent, info, allocator]: [Handle; 3],
    made: *mut Handle,
) -> i32 {
    unsafe {
        let mut chained: *mut Chained = (*info.cast::<Chained>()).next;
        while (*chained).kind != kind || (*chained).function != 0 {
            chained = (*chained).next;
        }
        let link = &*(*chained).link;
        (*chained).link = link.next;
        let create = (link.get_instance_proc)(INSTANCE.load(Relaxed), name.as_ptr());
        OF_INSTANCE.get_or_init(|| link.get_instance_proc);
        if kind == LOADER_DEVICE_CREATE_INFO {
            OF_DEVICE.get_or_init(|| link.get_device_proc);
            let create: Create = transmute(create);
            return create(parent, info.cast(), allocator, made);
        }
        let create: unsafe extern "C" fn(Handle, Handle, *mut Handle) -> i32 = transmute(create);
        create(info, allocator, made)
    }
}

unsafe extern "C" fn create_instance(info: Handle, with: Handle, made: *mut Handle) -> i32 {
    let result = unsafe {
        create(LOADER_INSTANCE_CREATE_INFO, c"vkCreateInstance", [null_mut(), info, with], made)
    };
    INSTANCE.store(unsafe { *made }, Relaxed);
    result
}

unsafe extern "C" fn create_device(
    of: Handle,
    info: Handle,
    with: Handle,
    made: *mut Handle,
) -> i32 {
    let result =
        unsafe { create(LOADER_DEVICE_CREATE_INFO, c"vkCreateDevice", [of, info, with], made) };
    DEVICE.store(unsafe { *made }, Relaxed);
    result
}

unsafe extern "C" fn allocate(
    device: Handle,
    info: *const Allocation,
    with: Handle,
    made: *mut u64,
) -> i32 {
    type Allocate = unsafe extern "C" fn(Handle, *const Allocation, Handle, *mut u64) -> i32;
    let mut allocated = ALLOCATED.lock().expect("nobody panics with it");
    let allocated = allocated.get_or_insert_default();
    unsafe {
        let size = (*info).size;
        if fault("memory").is_some_and(|all| allocated.values().sum::<u64>() + size > all) {
            return OUT_OF_DEVICE_MEMORY;
        }
        let allocate: Allocate = transmute(below(c"vkAllocateMemory"));
        let result = allocate(device, info, with, made);
        allocated.insert(*made, size);
        result
    }
}

unsafe extern "C" fn free(device: Handle, memory: u64, with: Handle) {
    let free: unsafe extern "C" fn(Handle, u64, Handle) =
        unsafe { transmute(below(c"vkFreeMemory")) };
    unsafe { free(device, memory, with) };
    let mut allocated = ALLOCATED.lock().expect("nobody panics with it");
    allocated.get_or_insert_default().remove(&memory);
}

/// A device is lost only once it has stopped working, so the loss is reported after the wait.
unsafe extern "C" fn wait(device: Handle, info: Handle, nanoseconds: u64) -> i32 {
    if fault("lost").is_some() {
        CALLS.fetch_add(1, Relaxed);
    }
    let wait: unsafe extern "C" fn(Handle, Handle, u64) -> i32 =
        unsafe { transmute(below(c"vkWaitSemaphores")) };
    let result = unsafe { wait(device, info, nanoseconds) };
    if came_to("lost") { DEVICE_LOST } else { result }
}

unsafe extern "C" fn finished(device: Handle, semaphore: u64, value: *mut u64) -> i32 {
    if came_to("lost") {
        return DEVICE_LOST;
    }
    let finished: unsafe extern "C" fn(Handle, u64, *mut u64) -> i32 =
        unsafe { transmute(below(c"vkGetSemaphoreCounterValue")) };
    unsafe { finished(device, semaphore, value) }
}

/// Hanging work is not even started.
unsafe extern "C" fn submit(queue: Handle, count: u32, submits: Handle, fence: u64) -> i32 {
    if fault("hang").is_some_and(|first| CALLS.fetch_add(1, Relaxed) + 1 >= first) {
        return 0;
    }
    let submit: unsafe extern "C" fn(Handle, u32, Handle, u64) -> i32 =
        unsafe { transmute(below(c"vkQueueSubmit")) };
    unsafe { submit(queue, count, submits, fence) }
}

unsafe extern "C" fn wait_idle(queue: Handle) -> i32 {
    if came_to("hang") {
        // Endless, except that the test must notice.
        sleep(Duration::from_secs(60));
        std::process::abort();
    }
    let wait: unsafe extern "C" fn(Handle) -> i32 = unsafe { transmute(below(c"vkQueueWaitIdle")) };
    let result = unsafe { wait(queue) };
    if came_to("lost") { DEVICE_LOST } else { result }
}

unsafe extern "C" fn dispatch(commands: Handle, x: u32, y: u32, z: u32) {
    if fault("wrong").is_some_and(|which| CALLS.fetch_add(1, Relaxed) + 1 == which) {
        return;
    }
    let dispatch: unsafe extern "C" fn(Handle, u32, u32, u32) =
        unsafe { transmute(below(c"vkCmdDispatch")) };
    unsafe { dispatch(commands, x, y, z) }
}

/// The layer's replacement for a function.
fn own(name: &CStr) -> Function {
    let address = match name.to_bytes() {
        b"vkGetInstanceProcAddr" => get_instance_proc as *const c_void,
        b"vkGetDeviceProcAddr" => get_device_proc as *const c_void,
        b"vkCreateInstance" => create_instance as *const c_void,
        b"vkCreateDevice" => create_device as *const c_void,
        b"vkAllocateMemory" => allocate as *const c_void,
        b"vkFreeMemory" => free as *const c_void,
        b"vkWaitSemaphores" | b"vkWaitSemaphoresKHR" => wait as *const c_void,
        b"vkGetSemaphoreCounterValue" | b"vkGetSemaphoreCounterValueKHR" => {
            finished as *const c_void
        }
        b"vkQueueSubmit" => submit as *const c_void,
        b"vkQueueWaitIdle" => wait_idle as *const c_void,
        b"vkCmdDispatch" => dispatch as *const c_void,
        _ => return None,
    };
    unsafe { transmute::<*const c_void, Function>(address) }
}

unsafe extern "C" fn get_instance_proc(instance: Handle, name: *const c_char) -> Function {
    let below = || unsafe { OF_INSTANCE.get().and_then(|get| get(instance, name)) };
    own(unsafe { CStr::from_ptr(name) }).or_else(below)
}

unsafe extern "C" fn get_device_proc(device: Handle, name: *const c_char) -> Function {
    let below = || unsafe { OF_DEVICE.get().and_then(|get| get(device, name)) };
    own(unsafe { CStr::from_ptr(name) }).or_else(below)
}
