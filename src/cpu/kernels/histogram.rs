//! Histograms without increments in memory: a pixel is a word with the bit of its bin set, and words
//! are added bit by bit, all bins at once, by carry-save adders (Harley and Seal's population count,
//! for every bit position on its own; see Muła, Kurz and Lemire, "Faster population counts using AVX2
//! instructions", 2018).

use crate::objective::HISTOGRAM_BINS;
use multiversion::multiversion;

/// Words side by side.
const ROW: usize = 32;
/// Rows of a block, a power of two.
const ROWS: usize = 32;
/// Pixels of a block.
const BLOCK: usize = ROWS * ROW;
/// Blocks before a byte that counts them is full.
const FULL: usize = 255;

type Row = [u32; ROW];
/// Counts of the bins `s`, `s + 8`, `s + 16`, `s + 24` in the four bytes of each word of row `s`.
type Bytes = [Row; 8];

/// Counts a picture's pixels in bins.
#[multiversion(targets = "simd")]
pub fn histogram(picture: &[f32]) -> [u32; HISTOGRAM_BINS] {
    histogram_in_lanes(picture)
}

#[inline(always)]
pub(super) fn histogram_in_lanes(picture: &[f32]) -> [u32; HISTOGRAM_BINS] {
    let mut counts = [0; HISTOGRAM_BINS];
    for part in picture.chunks(FULL * BLOCK) {
        count(part, &mut counts);
    }
    counts
}

/// Sums what the pixels weigh in bins.
pub fn weighted_histogram(picture: &[f32], weights: &[u8]) -> [u32; HISTOGRAM_BINS] {
    // Neighbours mostly fall into one bin: in tables of their own they need not wait for each other.
    let mut tables = [[0; HISTOGRAM_BINS]; 4];
    let mut add = |picture: &[f32], weights: &[u8]| {
        for ((table, &i), &weight) in tables.iter_mut().zip(picture).zip(weights) {
            table[bin_of(i) as usize] += u32::from(weight);
        }
    };
    let (mut groups, mut weighed) = (picture.chunks_exact(4), weights.chunks_exact(4));
    for (picture, weights) in (&mut groups).zip(&mut weighed) {
        add(picture, weights);
    }
    add(groups.remainder(), weighed.remainder());
    std::array::from_fn(|bin| tables.iter().map(|table| table[bin]).sum())
}

/// Counts the pixels of at most [`FULL`] blocks.
#[inline(always)]
fn count(part: &[f32], counts: &mut [u32; HISTOGRAM_BINS]) {
    // A pixel of a bin counts 1 in the first plane, 2 in the second, and so on.
    let mut planes = [[0; ROW]; ROWS.ilog2() as usize];
    let mut carried = Bytes::default();
    let mut words = [0; BLOCK];
    for block in part.chunks(BLOCK) {
        for (word, &i) in words.iter_mut().zip(block) {
            *word = 1 << bin_of(i);
        }
        words[block.len()..].fill(0);
        let mut rows = ROWS;
        for plane in &mut planes {
            rows /= 2;
            let (low, high) = words.split_at_mut(rows * ROW);
            for (low, high) in low.chunks_exact_mut(ROW).zip(high.chunks_exact(ROW)) {
                add_rows(plane, low, high);
            }
        }
        count_bits(&words[..ROW], 0, &mut carried);
    }
    let mut rest = Bytes::default();
    for (level, plane) in planes.iter().enumerate() {
        count_bits(plane, level, &mut rest);
    }
    for (bin, count) in counts.iter_mut().enumerate() {
        let byte = |word: u32| word >> (bin / 8 * 8) & 255;
        for (&carried, &rest) in carried[bin % 8].iter().zip(&rest[bin % 8]) {
            *count += ROWS as u32 * byte(carried) + byte(rest);
        }
    }
}

/// Adds two rows to `sum` and leaves the carry in the first of them.
#[inline(always)]
fn add_rows(sum: &mut Row, row: &mut [u32], other: &[u32]) {
    for k in 0..ROW {
        let (a, b, c) = (row[k], other[k], sum[k]);
        row[k] = (a & b) | ((a ^ b) & c);
        sum[k] = a ^ b ^ c;
    }
}

/// Adds `2^level` to the bins of every bit that is set.
#[inline(always)]
fn count_bits(words: &[u32], level: usize, bytes: &mut Bytes) {
    for (shift, row) in bytes.iter_mut().enumerate() {
        for (byte, word) in row.iter_mut().zip(words) {
            *byte += (word >> shift & 0x0101_0101) << level;
        }
    }
}

/// `min(31, floor(32·i))`, 0 for what is not above 0.
#[inline(always)]
fn bin_of(i: f32) -> u32 {
    const LAST: f32 = (HISTOGRAM_BINS - 1) as f32;
    let scaled = i * HISTOGRAM_BINS as f32;
    let positive = if scaled > 0.0 { scaled } else { 0.0 };
    let bin = if positive < LAST { positive } else { LAST };
    // `as` would look for values out of range once more, which takes longer than all of the rest.
    // SAFETY: `bin` lies in 0..=31; where `i` is not a number the first comparison has made it 0.
    let bin: i32 = unsafe { bin.to_int_unchecked() };
    bin as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn one_by_one(picture: &[f32]) -> [u32; HISTOGRAM_BINS] {
        let mut counts = [0; HISTOGRAM_BINS];
        picture.iter().for_each(|&i| counts[((i * 32.0) as usize).min(31)] += 1);
        counts
    }

    #[test]
    fn bins_are_those_of_the_plain_histogram() {
        let mut picture: Vec<f32> = (0..=64).map(|k| k as f32 / 64.0).collect();
        picture.extend([0.999_999_9, f32::NAN, -1.0, f32::INFINITY, 0.031_249_998]);
        for &i in &picture {
            let plain = ((i * 32.0) as u32).min(31);
            assert_eq!(bin_of(i), plain, "{i}");
        }
    }

    #[test]
    fn counts_are_those_of_counting_one_by_one() {
        let mut random = ChaCha8Rng::seed_from_u64(13);
        let mut picture: Vec<f32> = (0..3 * BLOCK + 7).map(|_| random.random()).collect();
        for len in [0, 1, ROW, BLOCK - 1, BLOCK, BLOCK + 1, picture.len()] {
            assert_eq!(histogram(&picture[..len]), one_by_one(&picture[..len]), "{len}");
        }
        let plain = one_by_one(&picture);
        picture[BLOCK] = 1.0 - picture[BLOCK];
        assert_ne!(histogram(&picture), plain);
    }

    #[test]
    fn weights_are_summed_one_by_one() {
        let mut random = ChaCha8Rng::seed_from_u64(17);
        let picture: Vec<f32> = (0..1003).map(|_| random.random()).collect();
        let mut weights: Vec<u8> = (0..1003).map(|_| random.random_range(0..64)).collect();
        let mut plain = [0; HISTOGRAM_BINS];
        for (&i, &weight) in picture.iter().zip(&weights) {
            plain[((i * 32.0) as usize).min(31)] += u32::from(weight);
        }
        assert_eq!(weighted_histogram(&picture, &weights), plain);
        weights[1002] ^= 1;
        assert_ne!(weighted_histogram(&picture, &weights), plain);
        assert_eq!(weighted_histogram(&picture, &[1; 1003]), one_by_one(&picture));
    }

    #[test]
    fn no_counter_overflows() {
        for (i, bin) in [(0.0, 0), (0.3, 9), (1.0, 31)] {
            let len = 2 * FULL * BLOCK + 5;
            assert_eq!(histogram(&vec![i; len])[bin], len as u32);
        }
    }
}
