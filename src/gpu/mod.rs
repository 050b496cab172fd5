//! Vulkan evaluator.
