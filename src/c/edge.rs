//! The edge between C and Rust: handles, messages, pointers, and what keeps panics inside.

use super::error::*;
use crate::Error;
use crate::error::panic_words;
use ash::vk;
use bytemuck::Zeroable;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Why a call fails.
pub(super) struct Fault {
    code: klieg_status,
    text: String,
}

pub(super) type Outcome<T = ()> = Result<T, Fault>;

impl Fault {
    pub fn new(code: klieg_status, text: impl Into<String>) -> Self {
        Self { code, text: text.into() }
    }

    pub fn argument(text: impl Into<String>) -> Self {
        Self::new(KLIEG_ERROR_ARGUMENT, text)
    }

    /// No fault, but nothing to give either.
    pub fn nothing_yet() -> Self {
        Self::new(KLIEG_NOTHING_YET, "nothing yet")
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::new(code(&error), error.to_string())
    }
}

fn code(error: &Error) -> klieg_status {
    use vk::Result as Vk;
    match error {
        Error::Argument(_) => KLIEG_ERROR_ARGUMENT,
        Error::Input { .. } => KLIEG_ERROR_INPUT,
        Error::Unsupported { .. } => KLIEG_ERROR_UNSUPPORTED,
        Error::NoVulkan(_) => KLIEG_ERROR_NO_VULKAN,
        Error::Forgotten => KLIEG_ERROR_FORGOTTEN,
        Error::Vulkan { result, .. } => match *result {
            Vk::ERROR_DEVICE_LOST => KLIEG_ERROR_DEVICE_LOST,
            Vk::ERROR_OUT_OF_HOST_MEMORY | Vk::ERROR_OUT_OF_DEVICE_MEMORY => KLIEG_ERROR_MEMORY,
            _ => KLIEG_ERROR_VULKAN,
        },
        Error::DeviceMemory { .. } => KLIEG_ERROR_MEMORY,
        Error::Output { .. } => KLIEG_ERROR_OUTPUT,
        Error::NotANumber { .. } | Error::Interrupted => KLIEG_ERROR_INTERNAL,
    }
}

thread_local! {
    /// The message of this thread's last call that failed without a handle to leave it with.
    pub(super) static LAST: RefCell<CString> = RefCell::default();
}

/// Where a handle's message is: the first that every handle has.
pub(super) enum Message {
    Own(CString),
    Thread,
}

/// `vkGetInstanceProcAddr`, or `NULL`.
pub type GetInstanceProcAddr = Option<vk::PFN_vkGetInstanceProcAddr>;

/// What an opaque type of the header stands for.
pub(super) trait Opaque {
    type Body: Send;
    /// Whether threads share its handles.
    const SHARED: bool = false;
}

/// What a handle points to.
#[repr(C)]
struct Handle<T> {
    message: Message,
    body: T,
}

fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

/// Runs `work`; a panic becomes a fault.
fn caught<T>(work: impl FnOnce() -> Outcome<T>) -> Outcome<T> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        Err(Fault::new(
            KLIEG_ERROR_INTERNAL,
            format!("klieg panicked: {}", panic_words(&*panic).unwrap_or("no message")),
        ))
    })
}

/// Leaves the message with the thread.
fn settle(outcome: Outcome) -> klieg_status {
    match outcome {
        Ok(()) => KLIEG_OK,
        Err(Fault { code, text }) => {
            // A thread that ends has nobody to read it.
            let _ = LAST.try_with(|last| *last.borrow_mut() = c_text(&text));
            code
        }
    }
}

/// A call without a handle of its own.
pub(super) fn free_call(work: impl FnOnce() -> Outcome) -> klieg_status {
    settle(caught(work))
}

/// A call that makes a handle; `*into` is `NULL` where it fails.
///
/// # Safety
/// `into` is `NULL` or may be written to.
pub(super) unsafe fn make<H: Opaque>(
    into: *mut *mut H,
    work: impl FnOnce() -> Outcome<H::Body>,
) -> klieg_status {
    // SAFETY: the caller's promise.
    settle(unsafe { put(into, std::ptr::null_mut(), "the place for the handle") }.and_then(|()| {
        let message = if H::SHARED { Message::Thread } else { Message::Own(CString::default()) };
        let handle = Handle { message, body: caught(work)? };
        // SAFETY: as above, and not `NULL`.
        unsafe { into.write(Box::into_raw(Box::new(handle)).cast()) };
        Ok(())
    }))
}

/// A call on a handle that one thread uses at a time.
///
/// # Safety
/// `handle` is `NULL` or alive, and nobody else uses it during the call.
pub(super) unsafe fn call<H: Opaque>(
    handle: *mut H,
    work: impl FnOnce(&mut H::Body) -> Outcome,
) -> klieg_status {
    const { assert!(!H::SHARED) };
    // SAFETY: the caller's promise.
    let Some(handle) = (unsafe { handle.cast::<Handle<H::Body>>().as_mut() }) else {
        return settle(Err(missing("the handle")));
    };
    match caught(|| work(&mut handle.body)) {
        Ok(()) => KLIEG_OK,
        Err(Fault { code, text }) => {
            handle.message = Message::Own(c_text(&text));
            code
        }
    }
}

/// Ends a handle; `NULL` is left alone.
///
/// # Safety
/// `handle` is `NULL` or alive, and is not used any more.
pub(super) unsafe fn destroy<H: Opaque>(handle: *mut H) {
    if !handle.is_null() {
        // SAFETY: made by `make`, and the caller's promise. A panic has nobody to tell.
        let _ = caught(|| unsafe {
            drop(Box::from_raw(handle.cast::<Handle<H::Body>>()));
            Ok(())
        });
    }
}

/// What a handle of the arguments stands for.
///
/// # Safety
/// `handle` is `NULL` or alive, and nobody changes it during `'a`.
pub(super) unsafe fn body<'a, H: Opaque>(handle: *const H, name: &str) -> Outcome<&'a H::Body>
where
    H::Body: 'a,
{
    // SAFETY: the caller's promise.
    let handle = unsafe { handle.cast::<Handle<H::Body>>().as_ref() };
    handle.map(|handle| &handle.body).ok_or_else(|| missing(name))
}

/// As [`body`], to be changed.
///
/// # Safety
/// `handle` is `NULL` or alive, and nobody else uses it during `'a`.
pub(super) unsafe fn body_mut<'a, H: Opaque>(handle: *mut H, name: &str) -> Outcome<&'a mut H::Body>
where
    H::Body: 'a,
{
    // SAFETY: the caller's promise.
    let handle = unsafe { handle.cast::<Handle<H::Body>>().as_mut() };
    handle.map(|handle| &mut handle.body).ok_or_else(|| missing(name))
}

fn missing(name: &str) -> Fault {
    Fault::argument(format!("{name} is NULL"))
}

/// A structure of the caller.
///
/// # Safety
/// `pointer` is `NULL` or points to a value that nobody changes during `'a`.
pub(super) unsafe fn given<'a, T>(pointer: *const T, name: &str) -> Outcome<&'a T> {
    // SAFETY: the caller's promise.
    unsafe { pointer.as_ref() }.ok_or_else(|| missing(name))
}

/// `N` numbers of the caller.
///
/// # Safety
/// `pointer` is `NULL` or points to them.
pub(super) unsafe fn numbers<const N: usize>(pointer: *const f64, name: &str) -> Outcome<[f64; N]> {
    // SAFETY: the caller's promise.
    unsafe { given(pointer.cast::<[f64; N]>(), name) }.copied()
}

/// Writes a result.
///
/// # Safety
/// `to` is `NULL` or may be written to.
pub(super) unsafe fn put<T>(to: *mut T, value: T, name: &str) -> Outcome {
    if to.is_null() {
        return Err(missing(name));
    }
    // SAFETY: the caller's promise.
    unsafe { to.write(value) };
    Ok(())
}

/// An array of the caller; `NULL` where it is empty.
///
/// # Safety
/// `pointer` is `NULL` or points to `count` values that nobody changes during `'a`.
pub(super) unsafe fn array<'a, T>(pointer: *const T, count: usize, name: &str) -> Outcome<&'a [T]> {
    check_length::<T>(count, name)?;
    match (pointer.is_null(), count) {
        (_, 0) => Ok(&[]),
        (true, _) => Err(missing(name)),
        // SAFETY: the caller's promise.
        (false, _) => Ok(unsafe { std::slice::from_raw_parts(pointer, count) }),
    }
}

/// As [`array`], `None` where there is no array at all.
///
/// # Safety
/// As [`array`].
pub(super) unsafe fn optional<'a, T>(
    pointer: *const T,
    count: usize,
    name: &str,
) -> Outcome<Option<&'a [T]>> {
    // SAFETY: the caller's promise.
    let values = || unsafe { array(pointer, count, name) };
    (!pointer.is_null()).then(values).transpose()
}

/// Room of the caller for results, zeroed.
///
/// # Safety
/// `pointer` is `NULL` or has room for `count` values that nobody else uses during `'a`.
pub(super) unsafe fn room<'a, T: Zeroable>(
    pointer: *mut T,
    count: usize,
    name: &str,
) -> Outcome<&'a mut [T]> {
    check_length::<T>(count, name)?;
    if count == 0 {
        return Ok(&mut []);
    }
    if pointer.is_null() {
        return Err(missing(name));
    }
    // SAFETY: the caller's promise; all bits zero are a value.
    unsafe {
        pointer.write_bytes(0, count);
        Ok(std::slice::from_raw_parts_mut(pointer, count))
    }
}

fn check_length<T>(count: usize, name: &str) -> Outcome {
    match count.checked_mul(size_of::<T>()) {
        Some(bytes) if bytes <= isize::MAX as usize => Ok(()),
        _ => Err(Fault::argument(format!("{name}: {count} are more than memory holds"))),
    }
}

/// A string of the caller; `NULL` is an empty one.
///
/// # Safety
/// `pointer` is `NULL` or a string with a terminating zero that nobody changes during `'a`.
pub(super) unsafe fn text<'a>(pointer: *const c_char, name: &str) -> Outcome<&'a str> {
    if pointer.is_null() {
        return Ok("");
    }
    // SAFETY: the caller's promise.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| Fault::argument(format!("{name} is not UTF-8")))
}

/// Which of `values` a number of the caller names, counted from 0.
pub(super) fn choice<T: Copy>(values: &[T], number: i32, name: &str) -> Outcome<T> {
    let value = usize::try_from(number).ok().and_then(|number| values.get(number));
    value.copied().ok_or_else(|| Fault::argument(format!("{name} {number} is not there")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ptr::{null, null_mut};

    struct Counter(());

    impl Opaque for Counter {
        type Body = u32;
    }

    fn said(handle: *const Counter) -> String {
        // SAFETY: the tests' handles are alive.
        unsafe { CStr::from_ptr(klieg_error(handle.cast())) }.to_str().unwrap().to_owned()
    }

    fn counter(start: u32) -> *mut Counter {
        let mut made = null_mut();
        // SAFETY: `made` may be written to.
        assert_eq!(unsafe { make(&mut made, || Ok(start)) }, KLIEG_OK);
        made
    }

    #[test]
    fn panics_and_faults_become_statuses_with_messages() {
        let (one, other) = (counter(1), counter(2));
        let broken = |_: &mut u32| -> Outcome { panic!("all is {}", "lost") };
        let refused = |_: &mut u32| Err(Fault::argument("too\0much"));
        // SAFETY: the handles are alive, and destroyed last.
        unsafe {
            assert_eq!(call(one, broken), KLIEG_ERROR_INTERNAL);
            assert_eq!(call(other, refused), KLIEG_ERROR_ARGUMENT);
            assert_eq!(said(one), "klieg panicked: all is lost");
            assert_eq!(said(other), "too much");
            let count = |n: &mut u32| {
                *n += 1;
                put(&mut 0, *n, "n")
            };
            assert_eq!((call(one, count), *body(one, "").ok().unwrap()), (KLIEG_OK, 2));
            assert_eq!(call(null_mut::<Counter>(), count), KLIEG_ERROR_ARGUMENT);
            assert_eq!(said(null()), "the handle is NULL");
            destroy(one);
            destroy(other);
            destroy(null_mut::<Counter>());
        }
    }

    #[test]
    fn what_is_not_made_is_null_and_its_message_the_threads() {
        let mut made = std::ptr::dangling_mut::<Counter>();
        // SAFETY: `made` may be written to.
        let status = unsafe { make(&mut made, || Err(Error::Forgotten.into())) };
        assert_eq!((status, made), (KLIEG_ERROR_FORGOTTEN, null_mut()));
        assert_eq!(said(null()), "the device is gone");
        let elsewhere = std::thread::spawn(|| said(null())).join().unwrap();
        assert_eq!(elsewhere, "");
    }

    #[test]
    fn errors_have_the_codes_of_the_header() {
        let vulkan = |result| code(&Error::Vulkan { call: "vkX", result });
        assert_eq!(vulkan(vk::Result::ERROR_DEVICE_LOST), KLIEG_ERROR_DEVICE_LOST);
        assert_eq!(vulkan(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY), KLIEG_ERROR_MEMORY);
        assert_eq!(vulkan(vk::Result::ERROR_UNKNOWN), KLIEG_ERROR_VULKAN);
        assert_eq!(code(&Error::input("a.glb", "bad")), KLIEG_ERROR_INPUT);
    }

    #[test]
    fn arrays_of_the_caller_are_checked() {
        let numbers = [1u32, 2, 3];
        // SAFETY: null pointers, and arrays of the stated lengths.
        unsafe {
            assert_eq!(array(numbers.as_ptr(), 3, "").ok(), Some(&numbers[..]));
            assert_eq!(array(null::<u32>(), 0, "").ok(), Some(&[][..]));
            assert!(array(null::<u32>(), 1, "").is_err());
            assert!(array(numbers.as_ptr(), usize::MAX / 2, "").is_err());
            assert_eq!(optional(null::<u32>(), 1, "").ok(), Some(None));
            let mut place = numbers;
            assert_eq!(room(place.as_mut_ptr(), 3, "").ok().unwrap(), [0; 3]);
            assert!(room(null_mut::<u32>(), 3, "").is_err());
            assert!(text(c"\xff".as_ptr(), "").is_err());
            assert_eq!(text(null(), "").ok(), Some(""));
        }
        assert_eq!(choice(&['a', 'b'], 1, "").ok(), Some('b'));
        assert!(choice(&['a', 'b'], 2, "").is_err() && choice(&['a', 'b'], -1, "").is_err());
    }
}
