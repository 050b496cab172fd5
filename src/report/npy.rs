//! Maps as NumPy arrays.

use npyz::WriterBuilder;
use std::io;

/// A `.npy` file of `values`, rows first, in the shape `shape`.
///
/// # Errors
/// When the shape does not hold as many values as there are.
pub fn array<T>(shape: &[u64], values: impl IntoIterator<Item = T>) -> io::Result<Vec<u8>>
where
    T: npyz::Serialize + npyz::AutoSerialize,
{
    let mut bytes = Vec::new();
    let options = npyz::WriteOptions::new().default_dtype().shape(shape);
    let mut writer = options.writer(&mut bytes).begin_nd()?;
    writer.extend(values)?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_read_back() {
        let bytes = array(&[2, 3], [1u32, 2, 3, 4, 5, 6]).unwrap();
        let file = npyz::NpyFile::new(&bytes[..]).unwrap();
        assert_eq!(file.shape(), [2, 3]);
        assert_eq!(file.into_vec::<u32>().unwrap(), [1, 2, 3, 4, 5, 6]);
        assert!(array(&[2, 3], [1.0f32; 5]).is_err());
    }
}
