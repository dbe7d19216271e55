//! Every law of Colluvium as a user material (UMAT) of Abaqus/Standard, so that Abaqus, Anura3D or an
//! incremental driver can call it.
//!
//! Build the shared library with `cargo build --release -p colluvium-umat`; it exports `umat_`. The
//! environment variable `COLLUVIUM_MATERIALS` names a JSON file of materials in the format of case files,
//!
//! ```json
//! { "sand": { "model": "mohr-coulomb", "density": 1800, "youngs_modulus": 2e7, "poissons_ratio": 0.3,
//!             "friction_angle": 32 } }
//! ```
//!
//! and the name of the material (`CMNAME`, upper or lower case) chooses one of them. `PROPS` is not read.
//! SI units, tension-positive, 11 22 33 12 13 23 with engineering shear, as in Abaqus; three-dimensional
//! stress (`NTENS = 6`), plane strain and axisymmetry (`NDI = 3`, `NSHR = 1`). The stress passed while
//! `STATEV(1)` is zero is the initial stress. Initial density is that of the material.
//!
//! `STATEV(1)` is the length of the state in bytes, the next numbers are the state (six bytes in each, so that
//! they are whole numbers which every program copies unchanged), the rest the law's outputs. A call that fails
//! (an unknown name, too few state variables, a step that does not converge) leaves stress and state
//! unchanged, sets `PNEWDT` to 0.25 and writes the reason to standard error.

#![allow(unsafe_code, reason = "the interface of a UMAT is raw pointers")]

use std::collections::HashMap;
use std::ffi::{c_char, c_int};
use std::sync::{Arc, OnceLock};

use colluvium_constitutive::{InitialCondition, Mat3, Material, MaterialSpec, Motion, States, SymTensor};

/// Environment variable with the path of the file of materials.
pub const MATERIALS: &str = "COLLUVIUM_MATERIALS";

/// Number of bytes of the state in each state variable. Whole numbers below 2⁴⁸ are exact in a double.
const BYTES: usize = 6;

/// Position of each component xx yy zz xy yz zx in the order 11 22 33 12 13 23 of Abaqus. The inverse permutation is equal.
const ORDER: [usize; 6] = [0, 1, 2, 3, 5, 4];

/// Law of a material, built from its parameters, with its density.
struct BuiltMaterial {
    law: Arc<dyn Material>,
    density: f64,
}

/// Materials of the file, by lower-case name.
fn materials() -> Result<&'static HashMap<String, BuiltMaterial>, String> {
    /// Materials of the process, built at the first call.
    static BUILT_MATERIALS: OnceLock<Result<HashMap<String, BuiltMaterial>, String>> = OnceLock::new();
    BUILT_MATERIALS.get_or_init(read_materials).as_ref().map_err(Clone::clone)
}

/// Builds the materials of the file that the environment variable names.
fn read_materials() -> Result<HashMap<String, BuiltMaterial>, String> {
    let file = std::env::var_os(MATERIALS).ok_or(format!("{MATERIALS} is not set to a file of materials"))?;
    let file = std::path::PathBuf::from(file);
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let specs: HashMap<String, MaterialSpec> =
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", file.display()))?;
    let ready = |(name, spec): (String, MaterialSpec)| {
        let law = spec.build().map_err(|error| format!("{}: {name}.{error}", file.display()))?;
        Ok((name.to_lowercase(), BuiltMaterial { law, density: spec.density() }))
    };
    specs.into_iter().map(ready).collect()
}

/// Packs the state of a point as numbers: its length in bytes, then the bytes.
fn pack(law: &dyn Material, states: &States) -> Vec<f64> {
    let bytes = law.save(states);
    let number = |part: &[u8]| part.iter().rev().fold(0u64, |n, byte| n << 8 | u64::from(*byte)) as f64;
    std::iter::once(bytes.len() as f64).chain(bytes.chunks(BYTES).map(number)).collect()
}

/// Unpacks the state from numbers made by [`pack`].
fn unpack(law: &dyn Material, numbers: &[f64]) -> Option<States> {
    let (length, rest) = numbers.split_first()?;
    let length = *length as usize;
    let mut bytes: Vec<u8> = Vec::with_capacity(length + BYTES);
    for number in rest.get(..length.div_ceil(BYTES))? {
        bytes.extend_from_slice(&(*number as u64).to_le_bytes()[..BYTES]);
    }
    bytes.truncate(length);
    law.load(&bytes).filter(|states| states.len() == 1)
}

/// Arguments of one call, as Rust types.
struct Call<'a> {
    name: String,
    stress: &'a mut [f64],
    state: &'a mut [f64],
    tangent: &'a mut [f64],
    /// Strain before the step, and its increment.
    strain: [&'a [f64]; 2],
    dt: f64,
    size: f64,
    rotation: Mat3,
    /// Deformation gradients before and after the step.
    deformation: [Mat3; 2],
}

/// Name of a material: C programs end it with a zero, Fortran pads it with blanks.
fn material_name(name: &[u8]) -> String {
    let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
    String::from_utf8_lossy(&name[..end]).trim().to_owned()
}

/// Matrix from its entries by columns, the order of Fortran.
fn from_columns(m: &[f64]) -> Mat3 {
    Mat3(std::array::from_fn(|i| std::array::from_fn(|j| m[3 * j + i])))
}

/// Tensor from `values` in the order of Abaqus, shear components times `shear`.
fn tensor(values: &[f64], shear: f64) -> SymTensor {
    let full: [f64; 6] =
        std::array::from_fn(|k| values.get(k).copied().unwrap_or(0.0) * if k < 3 { 1.0 } else { shear });
    SymTensor(std::array::from_fn(|k| full[ORDER[k]]))
}

/// Motion of the step. It follows from the deformation gradients where they differ, else from strain and rotation.
fn motion(call: &Call, density: f64) -> Option<Motion> {
    let volume = |f: &Mat3| f.determinant();
    let [before, after] = call.deformation;
    if before != after {
        let f = after * before.inverse()?;
        return Motion::from_deformation(&f, call.dt, density / volume(&after), call.size);
    }
    // Spin of a rotation after Hughes and Winget, W = 2 (Q - 1)(Q + 1)⁻¹.
    let q = call.rotation;
    let spin = (q - Mat3::IDENTITY) * (q + Mat3::IDENTITY).inverse()? * 2.0;
    let strain = tensor(call.strain[1], 0.5);
    let gradient = strain.to_matrix() + spin.skew();
    let growth = (tensor(call.strain[0], 0.5).trace() + strain.trace()).exp();
    Motion::from_velocity_gradient(&(gradient * (1.0 / call.dt)), call.dt, density / growth, call.size)
}

/// Updates the stress and state of the point of a call.
fn run(call: &mut Call) -> Result<(), String> {
    let known = materials()?;
    let BuiltMaterial { law, density } = known
        .get(&call.name.to_lowercase())
        .ok_or_else(|| format!("{:?} is not in {MATERIALS}", call.name))?;
    if !matches!(call.stress.len(), 4 | 6) {
        return Err(format!(
            "NTENS = {} is not supported: it must be 4 (plane strain, axisymmetry) or 6",
            call.stress.len()
        ));
    }
    // Abaqus has already rotated the stress; the law rotates it itself.
    let stress = tensor(call.stress, 1.0).rotated(&call.rotation.transpose());
    let fresh = call.state.first().copied().unwrap_or(0.0) == 0.0;
    let (stress, states) = if fresh {
        let condition = InitialCondition { stress, density: *density };
        let (stresses, states) = law.initial(&[condition]).map_err(|error| error.to_string())?;
        (stresses[0], states)
    } else {
        let states =
            unpack(&**law, call.state).ok_or("the state variables are not those of this material")?;
        (stress, states)
    };
    if call.dt <= 0.0 {
        call.dt = 1.0;
    }
    let motion = motion(call, *density).ok_or("the deformation of the step is singular")?;
    let tangent = law.tangent(&motion, &stress, &states.blocks()[0], 0).map_err(|error| error.to_string())?;
    let (mut new, mut stresses) = (states, [stress]);
    law.update(&[motion], &mut stresses, &mut new.blocks_mut()[0]).map_err(|error| error.to_string())?;
    let packed = pack(&**law, &new);
    if packed.len() > call.state.len() {
        let (needed, given) = (packed.len(), call.state.len());
        return Err(format!("{}: needs {needed} state variables (DEPVAR), has {given}", call.name));
    }
    let mut outputs = vec![0.0; law.output_names().len()];
    law.outputs(&stresses, &new.blocks()[0], &mut outputs);
    for (slot, value) in call.state.iter_mut().zip(packed.into_iter().chain(outputs)) {
        *slot = value;
    }
    let count = call.stress.len();
    for k in 0..count {
        call.stress[k] = stresses[0][ORDER[k]];
        for j in 0..count {
            call.tangent[j * count + k] = tangent.0[ORDER[k]][ORDER[j]];
        }
    }
    Ok(())
}

/// Runs a call and converts a panic to an error, since a panic must not cross into the language of the caller.
fn run_guarded(call: &mut Call) -> Result<(), String> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| run(call)))
        .unwrap_or_else(|_| Err("internal error".to_owned()))
}

/// User material of Abaqus/Standard. See the head of this crate.
///
/// # Safety
/// Every pointer must be to an array of the length required by the interface of a UMAT: `ntens` numbers in
/// `stress`, `stran` and `dstran`, `ntens²` in `ddsdde`, `nstatv` in `statev`, 80 bytes in `cmname`, 9 numbers
/// in `drot`, `dfgrd0` and `dfgrd1`, one in `dtime`, `pnewdt` and `celent`.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "the interface is not ours")]
pub unsafe extern "C" fn umat_(
    stress: *mut f64,
    statev: *mut f64,
    ddsdde: *mut f64,
    _sse: *mut f64,
    _spd: *mut f64,
    _scd: *mut f64,
    _rpl: *mut f64,
    _ddsddt: *mut f64,
    _drplde: *mut f64,
    _drpldt: *mut f64,
    stran: *const f64,
    dstran: *const f64,
    _time: *const f64,
    dtime: *const f64,
    _temp: *const f64,
    _dtemp: *const f64,
    _predef: *const f64,
    _dpred: *const f64,
    cmname: *const c_char,
    _ndi: *const c_int,
    _nshr: *const c_int,
    ntens: *const c_int,
    nstatv: *const c_int,
    _props: *const f64,
    _nprops: *const c_int,
    _coords: *const f64,
    drot: *const f64,
    pnewdt: *mut f64,
    celent: *const f64,
    dfgrd0: *const f64,
    dfgrd1: *const f64,
    _noel: *const c_int,
    _npt: *const c_int,
    _layer: *const c_int,
    _kspt: *const c_int,
    _kstep: *const c_int,
    _kinc: *const c_int,
    _cmname_length: usize,
) {
    // SAFETY: the lengths are those of the interface, guaranteed by the caller.
    unsafe {
        let [ntens, nstatv] = [ntens, nstatv].map(|count| usize::try_from(*count).unwrap_or(0));
        let mut call = Call {
            name: material_name(std::slice::from_raw_parts(cmname.cast::<u8>(), 80)),
            stress: std::slice::from_raw_parts_mut(stress, ntens),
            state: if nstatv == 0 { &mut [] } else { std::slice::from_raw_parts_mut(statev, nstatv) },
            tangent: std::slice::from_raw_parts_mut(ddsdde, ntens * ntens),
            strain: [stran, dstran].map(|values| std::slice::from_raw_parts(values, ntens)),
            dt: *dtime,
            size: *celent,
            rotation: from_columns(std::slice::from_raw_parts(drot, 9)),
            deformation: [dfgrd0, dfgrd1].map(|m| from_columns(std::slice::from_raw_parts(m, 9))),
        };
        if let Err(message) = run_guarded(&mut call) {
            eprintln!("colluvium umat: {message}");
            *pnewdt = 0.25;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_survive_packing() {
        for spec in MaterialSpec::examples() {
            let law = spec.build().unwrap();
            let stress = SymTensor::isotropic(-50e3);
            let (_, states) = law.initial(&[InitialCondition { stress, density: spec.density() }]).unwrap();
            let numbers = pack(&*law, &states);
            assert!(numbers.iter().all(|n| n.fract() == 0.0 && *n >= 0.0), "{}", spec.name());
            let back = unpack(&*law, &numbers).expect("its own numbers");
            assert_eq!(law.save(&back), law.save(&states), "{}", spec.name());
        }
    }
}
