//! klieg's errors as Python's exceptions.

use klieg::session::{describe, is_input};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

/// The exception of `klieg._errors` of that name.
fn exception(cell: &'static PyOnceLock<Py<PyType>>, name: &str, text: String) -> PyErr {
    Python::attach(|py| match cell.import(py, "klieg._errors", name) {
        Ok(class) => PyErr::from_type(class.clone(), text),
        // The module was loaded without its package.
        Err(_) => PyRuntimeError::new_err(text),
    })
}

/// The exception for an error of klieg: `klieg.InputError` where what the caller gave is at fault, else `klieg.Error`.
pub fn raised(error: &anyhow::Error) -> PyErr {
    static ERROR: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    if is_input(error) {
        refused(describe(error))
    } else {
        exception(&ERROR, "Error", describe(error))
    }
}

/// `klieg.InputError`.
pub fn refused(text: impl Into<String>) -> PyErr {
    static INPUT: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    exception(&INPUT, "InputError", text.into())
}

/// A result whose error becomes an exception.
pub trait OrRaise<T> {
    /// The value, or the exception.
    fn or_raise(self) -> PyResult<T>;
}

impl<T, E: Into<anyhow::Error>> OrRaise<T> for Result<T, E> {
    fn or_raise(self) -> PyResult<T> {
        self.map_err(|error| raised(&error.into()))
    }
}
