//! Internal force of a stress, as columns of a matrix.

use colluvium_constitutive::SymTensor;
use colluvium_grid::Vector4;

/// Force columns `columns[j] = -V σ e_j`.
#[inline(always)]
pub fn force_columns<const D: usize>(stress: &SymTensor, volume: f64) -> [Vector4; D] {
    let s = &stress.0;
    let columns = [
        Vector4::new([s[0], s[3], s[5], 0.0]),
        Vector4::new([s[3], s[1], s[4], 0.0]),
        Vector4::new([s[5], s[4], s[2], 0.0]),
    ];
    let mut mask = [0.0; 4];
    mask[..D].fill(-volume);
    let scale = Vector4::new(mask);
    std::array::from_fn(|j| columns[j] * scale)
}
