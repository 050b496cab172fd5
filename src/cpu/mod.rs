//! Native evaluator and the plain twins of the GPU stages.
