//! Searches over genomes.
