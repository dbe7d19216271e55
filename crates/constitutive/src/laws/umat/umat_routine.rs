//! Routine of a user material in a shared library, and the law that calls it.

use std::ffi::{c_char, c_int};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use libloading::Library;
use serde::{Deserialize, Serialize};

use crate::adapters::corotational::half_rotation;
use crate::laws::umat::{NAME, UmatSpec, shared_library};
use crate::{
    InitialCondition, Law, Mat3, Material, MaterialError, Motion, Point, PointLaw, StressUpdate, SymTensor,
    Tangent,
};

/// Builds the law of a checked specification.
pub(super) fn build(spec: &UmatSpec) -> Result<Arc<dyn Material>, MaterialError> {
    let routine = Routine::load(&spec.library, &spec.symbol)?;
    Ok(Arc::new(Umat { spec: spec.clone(), routine }))
}

/// Index of each component xx yy zz xy yz zx among 11 22 33 12 13 23, and the inverse.
const ORDER: [usize; 6] = [0, 1, 2, 3, 5, 4];

/// Argument `JSTEP`: number of the step, its procedure (static), nonlinear geometry, and no perturbation step. Older routines
/// call it `KSTEP`, the number alone.
const STEP_ARGUMENT: [c_int; 4] = [1, 1, 1, 0];

/// Signature of `umat_` from Fortran compilers, the hidden length of `CMNAME` last.
type UmatFunction = unsafe extern "C" fn(
    stress: *mut f64,
    statev: *mut f64,
    ddsdde: *mut f64,
    sse: *mut f64,
    spd: *mut f64,
    scd: *mut f64,
    rpl: *mut f64,
    ddsddt: *mut f64,
    drplde: *mut f64,
    drpldt: *mut f64,
    stran: *const f64,
    dstran: *const f64,
    time: *const f64,
    dtime: *const f64,
    temp: *const f64,
    dtemp: *const f64,
    predef: *const f64,
    dpred: *const f64,
    cmname: *const c_char,
    ndi: *const c_int,
    nshr: *const c_int,
    ntens: *const c_int,
    nstatv: *const c_int,
    props: *const f64,
    nprops: *const c_int,
    coords: *const f64,
    drot: *const f64,
    pnewdt: *mut f64,
    celent: *const f64,
    dfgrd0: *const f64,
    dfgrd1: *const f64,
    noel: *const c_int,
    npt: *const c_int,
    layer: *const c_int,
    kspt: *const c_int,
    jstep: *const c_int,
    kinc: *const c_int,
    cmname_length: usize,
);

/// Loaded routine and the lock of its library.
struct Routine {
    function: UmatFunction,
    lock: Arc<Mutex<()>>,
    /// Library handle, which keeps the code mapped.
    _library: Arc<Library>,
}

impl Routine {
    /// Loads a routine with the interface of a UMAT from a shared library.
    #[allow(unsafe_code, reason = "code of another language can be called in no other way")]
    fn load(path: &Path, symbol: &str) -> Result<Self, MaterialError> {
        let (library, lock) = shared_library::open(path)?;
        // SAFETY: the symbol is a routine with the interface of a UMAT, guaranteed by the user;
        // the library outlives the pointer.
        let function = match unsafe { library.get::<UmatFunction>(symbol.as_bytes()) } {
            Ok(function) => *function,
            Err(error) => {
                let rule = format!(
                    "{symbol:?} is not in {}: {}",
                    path.display(),
                    shared_library::load_error(&error)
                );
                return Err(MaterialError::incompatible_options("symbol", rule));
            }
        };
        Ok(Self { function, lock, _library: library })
    }
}

/// Law of a user material. The comment of [`umat`](super) has its source and its limits.
struct Umat {
    spec: UmatSpec,
    routine: Routine,
}

/// State of a point of a user material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct UmatState {
    /// State variables `STATEV`.
    variables: Vec<f64>,
    /// Total strain in the co-rotating frame, tensor shear (`STRAN` doubles it).
    strain: SymTensor,
    /// Deformation gradient since the start, `DFGRD0` of the next step.
    deformation: Mat3,
    /// Time (s).
    time: f64,
    /// Bound on the P-wave modulus from `DDSDDE` (Pa).
    modulus: f64,
}

/// Stress, state variables and tangent after a call of the routine.
struct UmatOutput {
    stress: SymTensor,
    variables: Vec<f64>,
    tangent: Tangent,
}

/// Components in the order of a UMAT, with the shear components multiplied by `shear`.
fn to_umat(tensor: &SymTensor, shear: f64) -> [f64; 6] {
    std::array::from_fn(|k| tensor[ORDER[k]] * if k < 3 { 1.0 } else { shear })
}

/// Tensor of components in the order of a UMAT.
fn from_umat(values: [f64; 6]) -> SymTensor {
    SymTensor(std::array::from_fn(|k| values[ORDER[k]]))
}

/// Components of a matrix in column-major order, as in Fortran.
fn column_major(m: &Mat3) -> [f64; 9] {
    std::array::from_fn(|k| m.0[k % 3][k / 3])
}

/// Number of values behind the arrays of variable length, by which a library is noticed that uses more than it was given.
const GUARD_VALUES: usize = 64;
/// Value behind the state variables, which a correct library does not change.
const UNTOUCHED: f64 = -1.234_567_890_123_456_7e-289;

/// Arguments of a call, named as in the interface of a UMAT.
struct UmatArguments {
    stress: [f64; 6],
    /// State variables, and [`UNTOUCHED`] behind them.
    statev: Vec<f64>,
    ddsdde: [f64; 36],
    /// Energies and heat, `SSE`, `SPD`, `SCD`, `RPL` and `DRPLDT`, which are not used.
    energies: [f64; 5],
    ddsddt: [f64; 6],
    drplde: [f64; 6],
    stran: [f64; 6],
    dstran: [f64; 6],
    time: [f64; 2],
    dtime: f64,
    cmname: [u8; 80],
    nstatv: usize,
    /// Properties, and values that are not numbers behind them, with which a library that reads too many gives no stress.
    props: Vec<f64>,
    nprops: usize,
    drot: [f64; 9],
    pnewdt: f64,
    celent: f64,
    dfgrd0: [f64; 9],
    dfgrd1: [f64; 9],
}

impl UmatArguments {
    /// Arguments of a step, with the stress already rotated by `rotation`.
    fn new(spec: &UmatSpec, stress: &SymTensor, state: &UmatState, motion: &Motion, rotation: &Mat3) -> Self {
        let guarded = |values: &[f64], behind: f64| [values, &[behind; GUARD_VALUES]].concat();
        let mut cmname = [b' '; 80];
        cmname[..spec.material_name.len()].copy_from_slice(spec.material_name.as_bytes());
        Self {
            stress: to_umat(&(*stress * (1.0 / spec.unit())), 1.0),
            statev: guarded(&state.variables, UNTOUCHED),
            ddsdde: [0.0; 36],
            energies: [0.0; 5],
            ddsddt: [0.0; 6],
            drplde: [0.0; 6],
            stran: to_umat(&state.strain, 2.0),
            dstran: to_umat(&motion.strain_increment(), 2.0),
            time: [state.time, state.time],
            dtime: motion.dt,
            cmname,
            nstatv: state.variables.len(),
            props: guarded(&spec.props, f64::NAN),
            nprops: spec.props.len(),
            drot: column_major(rotation),
            pnewdt: 1.0,
            celent: motion.size,
            dfgrd0: column_major(&state.deformation),
            dfgrd1: column_major(&(motion.deformation * state.deformation)),
        }
    }

    /// Calls the routine once.
    #[allow(unsafe_code, reason = "code of another language can be called in no other way")]
    fn call(&mut self, function: UmatFunction) {
        let [temp, dtemp, predef, dpred] = [0.0; 4];
        let number = |n: usize| c_int::try_from(n).unwrap_or(c_int::MAX);
        let (ndi, nshr, ntens) = (3, 3, 6);
        let (nstatv, nprops) = (number(self.nstatv), number(self.nprops));
        let coords = [0.0; 3];
        let counter: c_int = 1;
        let [sse, spd, scd, rpl, drpldt] = &mut self.energies;
        // SAFETY: every pointer is to a live array of the length required by the interface of a UMAT; the use
        // of them by the library is the responsibility of the user.
        shared_library::call_guarded(|| unsafe {
            function(
                self.stress.as_mut_ptr(),
                self.statev.as_mut_ptr(),
                self.ddsdde.as_mut_ptr(),
                sse,
                spd,
                scd,
                rpl,
                self.ddsddt.as_mut_ptr(),
                self.drplde.as_mut_ptr(),
                drpldt,
                self.stran.as_ptr(),
                self.dstran.as_ptr(),
                self.time.as_ptr(),
                &raw const self.dtime,
                &raw const temp,
                &raw const dtemp,
                &raw const predef,
                &raw const dpred,
                self.cmname.as_ptr().cast(),
                &raw const ndi,
                &raw const nshr,
                &raw const ntens,
                &raw const nstatv,
                self.props.as_ptr(),
                &raw const nprops,
                coords.as_ptr(),
                self.drot.as_ptr(),
                &raw mut self.pnewdt,
                &raw const self.celent,
                self.dfgrd0.as_ptr(),
                self.dfgrd1.as_ptr(),
                &raw const counter,
                &raw const counter,
                &raw const counter,
                &raw const counter,
                STEP_ARGUMENT.as_ptr(),
                &raw const counter,
                self.cmname.len(),
            );
        });
    }

    /// Output of the call, in Pa where the library's unit of stress is `unit` (Pa).
    fn output(mut self, unit: f64) -> Result<UmatOutput, MaterialError> {
        if self.pnewdt < 1.0 {
            return Err(MaterialError::NotConverged {
                model: NAME,
                reason: "the library requests a shorter step",
            });
        }
        if self.statev[self.nstatv..].iter().any(|value| value.to_bits() != UNTOUCHED.to_bits()) {
            let reason = "the library wrote behind STATEV: give as many state_variables as it uses";
            return Err(MaterialError::Motion { model: NAME, reason });
        }
        self.statev.truncate(self.nstatv);
        let stress = from_umat(self.stress) * unit;
        if !(stress.is_finite() && self.statev.iter().all(|value| value.is_finite())) {
            let reason = "the library returned a stress or a state variable that is not finite: check that props has \
                          as many values as it reads";
            return Err(MaterialError::Motion { model: NAME, reason });
        }
        // DDSDDE(i, j) is column-major.
        let tangent = Tangent(std::array::from_fn(|i| {
            std::array::from_fn(|j| self.ddsdde[ORDER[j] * 6 + ORDER[i]] * unit)
        }));
        if !tangent.0.iter().flatten().all(|value| value.is_finite()) {
            let reason = "the library returned a stiffness (DDSDDE) that is not finite";
            return Err(MaterialError::Motion { model: NAME, reason });
        }
        Ok(UmatOutput { stress, variables: self.statev, tangent })
    }
}

impl Umat {
    /// Calls the routine once; the stress must already be rotated by `rotation`.
    fn call(
        &self,
        stress: &SymTensor,
        state: &UmatState,
        motion: &Motion,
        rotation: &Mat3,
    ) -> Result<UmatOutput, MaterialError> {
        let mut arguments = UmatArguments::new(&self.spec, stress, state, motion, rotation);
        {
            let _turn = (!self.spec.thread_safe)
                .then(|| self.routine.lock.lock().unwrap_or_else(PoisonError::into_inner));
            arguments.call(self.routine.function);
        }
        arguments.output(self.spec.unit())
    }

    /// Rotation increment of the step, the argument `DROT` of a UMAT.
    fn rotation(motion: &Motion) -> Mat3 {
        half_rotation(&motion.velocity_gradient_dt).map_or(Mat3::IDENTITY, |half| half * half)
    }

    /// Bound on the P-wave modulus (Pa): the largest normal stiffness, with a margin for anisotropy.
    fn wave_modulus_bound(&self, tangent: &Tangent) -> f64 {
        self.spec.wave_modulus.unwrap_or_else(|| 1.1 * (0..3).fold(0.0, |m: f64, i| m.max(tangent.0[i][i])))
    }

    /// Requires a finite motion without inversion and a strain increment below 1.
    fn check_motion(motion: &Motion) -> Result<(), MaterialError> {
        let sound = motion.velocity_gradient_dt.is_finite()
            && motion.deformation.is_finite()
            && motion.dt.is_finite();
        let reason = if !sound {
            "the motion is not finite"
        } else if motion.deformation.determinant() <= 0.0 {
            "the step inverts the point"
        } else if motion.strain_increment().norm() >= 1.0 {
            "a strain of more than 1 in one step"
        } else {
            return Ok(());
        };
        Err(MaterialError::Motion { model: NAME, reason })
    }
}

impl Law for Umat {
    fn name(&self) -> &'static str {
        NAME
    }

    /// Whether the law is isotropic: false, since the use of directions by a library is unknown.
    fn is_isotropic(&self) -> bool {
        false
    }

    fn is_hypoelastic(&self) -> bool {
        true
    }

    /// Whether the law depends on time: true, since the use of time by a library is unknown.
    fn is_time_dependent(&self) -> bool {
        true
    }
}

impl PointLaw for Umat {
    type State = UmatState;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<UmatState>, MaterialError> {
        if !initial.stress.is_finite() {
            let reason = "the stress is not finite".to_owned();
            return Err(MaterialError::Initial { model: NAME, reason });
        }
        let mut state = UmatState {
            variables: self.spec.state_variables.clone(),
            strain: SymTensor::ZERO,
            deformation: Mat3::IDENTITY,
            time: 0.0,
            modulus: 0.0,
        };
        // A step without strain gives the stiffness at the start.
        let still = Motion { density: initial.density, ..Motion::AT_REST };
        let called = self.call(&initial.stress, &state, &still, &Mat3::IDENTITY)?;
        state.modulus = self.wave_modulus_bound(&called.tangent);
        if !(state.modulus > 0.0 && state.modulus.is_finite()) {
            let reason = "the library returns no stiffness (DDSDDE): give wave_modulus".to_owned();
            return Err(MaterialError::Initial { model: NAME, reason });
        }
        Ok(Point { stress: initial.stress, state })
    }

    fn wave_modulus(&self, point: &Point<UmatState>) -> f64 {
        point.state.modulus
    }
}

impl StressUpdate for Umat {
    fn update(&self, motion: &Motion, old: &Point<UmatState>) -> Result<Point<UmatState>, MaterialError> {
        Self::check_motion(motion)?;
        let rotation = Self::rotation(motion);
        let called = self.call(&old.stress.rotated(&rotation), &old.state, motion, &rotation)?;
        let state = UmatState {
            variables: called.variables,
            strain: old.state.strain.rotated(&rotation) + motion.strain_increment(),
            deformation: motion.deformation * old.state.deformation,
            time: old.state.time + motion.dt,
            modulus: self.wave_modulus_bound(&called.tangent).max(f64::MIN_POSITIVE),
        };
        Ok(Point { stress: called.stress, state })
    }

    fn state_size(&self) -> usize {
        // A library that requests no variable gets one nevertheless.
        size_of::<UmatState>() + self.spec.state_variables.len().max(1) * size_of::<f64>()
    }

    fn tangent(&self, motion: &Motion, old: &Point<UmatState>) -> Result<Tangent, MaterialError> {
        Self::check_motion(motion)?;
        let rotation = Self::rotation(motion);
        Ok(self.call(&old.stress.rotated(&rotation), &old.state, motion, &rotation)?.tangent)
    }
}
