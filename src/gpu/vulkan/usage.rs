//! Memory for buffers and images, and how much of it is in use.

use super::allocator::{Access, DeviceMemory, MemoryRequest};
use crate::gpu::Context;
use crate::{Error, Result};
use serde::Serialize;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Bytes that buffers and images ask for. Allocators take memory in blocks, so that the device lends more.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct MemoryUse {
    /// Bytes that the device alone touches.
    pub device: u64,
    /// Bytes that the host touches too.
    pub mapped: u64,
}

impl MemoryUse {
    /// Bytes in all.
    pub fn total(self) -> u64 {
        self.device + self.mapped
    }

    fn of(&mut self, access: Access) -> &mut u64 {
        match access {
            Access::Device => &mut self.device,
            Access::Upload | Access::Readback => &mut self.mapped,
        }
    }
}

/// What is in use, and what was when most was.
#[derive(Default)]
pub struct Usage(Mutex<[MemoryUse; 2]>);

impl Usage {
    fn lock(&self) -> MutexGuard<'_, [MemoryUse; 2]> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, access: Access, bytes: u64) {
        let [now, most] = &mut *self.lock();
        *now.of(access) += bytes;
        if now.total() > most.total() {
            *most = *now;
        }
    }

    fn subtract(&self, access: Access, bytes: u64) {
        *self.lock()[0].of(access) -= bytes;
    }
}

/// Memory of a buffer or an image.
pub struct Piece {
    /// What the allocator gave; nothing on a dry context.
    pub memory: Option<DeviceMemory>,
    /// How much was asked for.
    pub bytes: u64,
    access: Access,
}

impl Context {
    /// Bytes that buffers and images take at the moment; see [`Context::memory_taken`] for what allocators take
    /// for them.
    pub fn memory_use(&self) -> MemoryUse {
        self.usage.lock()[0]
    }

    /// The same of the moment when they took most so far.
    pub fn most_memory_use(&self) -> MemoryUse {
        self.usage.lock()[1]
    }

    pub(in crate::gpu) fn allocate(&self, request: &MemoryRequest<'_>) -> Result<Piece> {
        self.check_present()?;
        let memory =
            match self.is_dry() {
                true => None,
                false => Some(self.allocator().allocate(request).map_err(|source| {
                    Error::DeviceMemory { what: request.name.to_owned(), source }
                })?),
            };
        self.count_allocation();
        let (access, bytes) = (request.access, request.requirements.size);
        self.usage.add(access, bytes);
        Ok(Piece { memory, bytes, access })
    }

    pub(in crate::gpu) fn free(&self, piece: Piece) {
        self.usage.subtract(piece.access, piece.bytes);
        if let (Some(memory), Ok(())) = (piece.memory, self.check_present()) {
            self.allocator().free(memory);
        }
    }
}
