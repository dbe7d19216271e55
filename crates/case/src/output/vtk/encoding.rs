//! Arrays of numbers as the text of VTK's XML files: compressed in blocks, in base 64.
//!
//! Whole numbers of eight bytes precede the data: for compressed data the number of blocks, their length, the length of the last one where
//! it is shorter, and the compressed length of each; for other data the number of bytes.

use std::io;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compress, FlushCompress, Status};
use rayon::prelude::*;
use vtkio::model::IOBuffer;

use crate::description::Compression;

/// Length of a part of an array that is compressed separately (bytes), equal to that of ParaView.
const BLOCK: usize = 1 << 15;

/// Encodes an array as text.
///
/// # Errors
/// When zlib fails.
pub(crate) fn encode(values: &IOBuffer, compression: Compression) -> io::Result<String> {
    let bytes = bytes(values)?;
    if compression == Compression::None {
        let whole = [&(bytes.len() as u64).to_le_bytes(), bytes.as_slice()].concat();
        return Ok(STANDARD.encode(whole));
    }
    let block = block_length(bytes.len());
    let make = || Compress::new(flate2::Compression::new(compression.level()), true);
    // Each block is compressed from a fresh state, on whichever thread.
    let blocks: io::Result<Vec<Vec<u8>>> = match bytes.is_empty() {
        true => compressed(&mut make(), &bytes).map(|block| vec![block]),
        false => bytes.par_chunks(block).map_init(make, compressed).collect(),
    };
    let blocks = blocks?;
    let head = [blocks.len(), block, bytes.len() % block].into_iter().chain(blocks.iter().map(Vec::len));
    let head: Vec<u8> = head.flat_map(|number| (number as u64).to_le_bytes()).collect();
    let mut text = STANDARD.encode(head);
    STANDARD.encode_string(blocks.concat(), &mut text);
    Ok(text)
}

/// Length of the compressed parts of an array of `bytes` bytes. The last one is always shorter, since readers do not agree on the length of
/// a full last one.
fn block_length(bytes: usize) -> usize {
    (1..=BLOCK / 8)
        .rev()
        .map(|numbers| 8 * numbers)
        .find(|block| !bytes.is_multiple_of(*block))
        .unwrap_or(BLOCK)
}

/// Compresses a block with zlib.
fn compressed(zlib: &mut Compress, block: &[u8]) -> io::Result<Vec<u8>> {
    // Noise grows by five bytes in each stored block of zlib, which is 16 kB or more.
    let mut out = vec![0; block.len() + block.len() / 1000 + 64];
    zlib.reset();
    let status = zlib.compress(block, &mut out, FlushCompress::Finish)?;
    if status != Status::StreamEnd {
        return Err(io::Error::other("zlib did not end a block"));
    }
    out.truncate(zlib.total_out() as usize);
    Ok(out)
}

/// Bytes of numbers, least significant first.
fn bytes(values: &IOBuffer) -> io::Result<Vec<u8>> {
    /// Converts numbers to bytes, eight each.
    fn encode_values<T: Copy>(values: &[T], bytes: impl Fn(T) -> [u8; 8]) -> Vec<u8> {
        let mut all = vec![0; 8 * values.len()];
        for (place, value) in all.as_chunks_mut().0.iter_mut().zip(values) {
            *place = bytes(*value);
        }
        all
    }
    match values {
        IOBuffer::F64(values) => Ok(encode_values(values, f64::to_le_bytes)),
        IOBuffer::I64(values) => Ok(encode_values(values, i64::to_le_bytes)),
        IOBuffer::U64(values) => Ok(encode_values(values, u64::to_le_bytes)),
        IOBuffer::U8(values) => Ok(values.clone()),
        other => {
            Err(io::Error::other(format!("numbers of the kind {:?} are not written", other.scalar_type())))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of the header and compressed blocks of a text.
    fn decode_blocks(text: &str) -> (Vec<u64>, Vec<u8>) {
        let number = |bytes: &[u8]| u64::from_le_bytes(bytes[..8].try_into().unwrap());
        let count = number(&STANDARD.decode(&text[..12]).unwrap()[..8]) as usize;
        let head = 4 * (8 * (3 + count)).div_ceil(3);
        let numbers = STANDARD.decode(&text[..head]).unwrap();
        (numbers.chunks(8).map(number).collect(), STANDARD.decode(&text[head..]).unwrap())
    }

    #[test]
    fn the_last_block_is_never_full() {
        for count in [0, 1, 4095, 4096, 4097, 4096 * 4095, 3 * 4096] {
            let values = IOBuffer::U8(vec![7; 8 * count]);
            let (head, data) = decode_blocks(&encode(&values, Compression::Fast).unwrap());
            let [blocks, block, last] = [head[0], head[1], head[2]];
            assert!(last > 0 || count == 0);
            assert_eq!((blocks - 1) * block + last, 8 * count as u64, "{count} numbers");
            assert_eq!(head[3..].iter().sum::<u64>(), data.len() as u64);
            assert_eq!(head.len() as u64, 3 + blocks);
        }
    }

    #[test]
    fn incompressible_data_are_encoded_and_recovered_block_by_block() {
        let mut state = 1_u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state ^ state >> 31
        };
        let values: Vec<u64> = (0..10_000).map(|_| noise()).collect();
        for compression in [Compression::Fast, Compression::Best] {
            let (head, data) = decode_blocks(&encode(&IOBuffer::U64(values.clone()), compression).unwrap());
            let mut rest = data.as_slice();
            let mut back = Vec::new();
            for length in &head[3..] {
                let (block, after) = rest.split_at(*length as usize);
                io::copy(&mut flate2::read::ZlibDecoder::new(block), &mut back).unwrap();
                rest = after;
            }
            let expected: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            assert_eq!(back, expected);
        }
    }
}
