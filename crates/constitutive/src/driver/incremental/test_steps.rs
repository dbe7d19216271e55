//! Steps of `test.inp`.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use crate::driver::incremental::{NumberedLines, TEST, TestProblem};
use crate::driver::{LoadingPath, TestStage};

/// Supported keywords of steps.
const KEYWORDS: [&str; 14] = [
    "*LinearLoad",
    "*CirculatingLoad",
    "*DeformationGradient",
    "*OedometricE1",
    "*OedometricS1",
    "*TriaxialE1",
    "*TriaxialS1",
    "*TriaxialUEq",
    "*TriaxialUq",
    "*PureRelaxation",
    "*PureCreep",
    "*UndrainedCreep",
    "*Repetition",
    "*End",
];

/// Largest number of steps with repetitions; a larger number is reported as an error.
const MAX_STEPS: usize = 100_000;

/// Title and loading steps in `test.inp`.
pub(super) struct TestSteps {
    /// Title of the test: the text after `#` on the first line, or the name of the output file.
    pub(super) title: String,
    /// Loading steps in the order of the test, with repetitions written out.
    pub(super) steps: Vec<TestStep>,
}

/// Step of the test: the stage, its output interval and the line of its keyword.
#[derive(Clone)]
pub(super) struct TestStep {
    /// Loading path, number of increments and duration (s) of the step.
    pub(super) stage: TestStage,
    /// Number of increments between two output rows.
    pub(super) output_interval: usize,
    /// Line of the keyword in the file.
    pub(super) line: usize,
}

/// Title and steps of the test, read from the text of `test.inp`; `unit` is the stress unit of the file (Pa).
pub(super) fn read_steps(text: &str, unit: f64) -> Result<TestSteps, TestProblem> {
    let mut lines = NumberedLines::new(TEST, text);
    let first = lines.require_line("the name of the output file")?;
    if first.starts_with('*') {
        return Err(lines.problem("the first line names the output file; the steps come after it"));
    }
    let (output, heading) = first.split_once('#').unwrap_or((first, ""));
    let title = if heading.trim().is_empty() { output } else { heading }.trim().to_owned();
    let mut steps = Vec::new();
    while let Some(line) = lines.next_line() {
        match keyword(line) {
            "*End" => break,
            "*Repetition" => repetition(&mut lines, unit, &mut steps)?,
            keyword => steps.push(step(keyword, &mut lines, unit)?),
        }
    }
    Ok(TestSteps { title, steps })
}

/// Keyword of a line in its standard spelling, without a remark. It is the line itself if it has no supported keyword or a condition.
fn keyword(line: &str) -> &str {
    let word = line.split(|c: char| c.is_whitespace() || c == '#').next().unwrap_or_default();
    let known = KEYWORDS.iter().find(|known| known.eq_ignore_ascii_case(word));
    known.filter(|_| !line.contains('?')).copied().unwrap_or(line)
}

/// Appends the steps of a `*Repetition`, as many times as the file requires.
fn repetition(
    lines: &mut NumberedLines<'_>,
    unit: f64,
    steps: &mut Vec<TestStep>,
) -> Result<(), TestProblem> {
    let what = "the numbers of steps and of repetitions";
    let [count, times] = lines.numbers(what)?;
    let (count, times) = (lines.integer(count, what)?, lines.integer(times, what)?);
    if count.saturating_mul(times).saturating_add(steps.len()) > MAX_STEPS {
        return Err(lines.problem(format!("{count} steps {times} times are more than {MAX_STEPS}")));
    }
    let mut repeated = Vec::new();
    for _ in 0..count {
        let keyword = keyword(lines.require_line("a step of the repetition")?);
        if matches!(keyword, "*Repetition" | "*End") {
            return Err(lines.problem(format!("{keyword} is not allowed inside *Repetition")));
        }
        repeated.push(step(keyword, lines, unit)?);
    }
    (0..times).for_each(|_| steps.extend_from_slice(&repeated));
    Ok(())
}

/// Step of a keyword, read with its increments and loading path.
fn step(keyword: &str, lines: &mut NumberedLines<'_>, unit: f64) -> Result<TestStep, TestProblem> {
    let line = lines.number;
    if keyword.contains('?') {
        return Err(lines.problem(format!("{keyword:?}: conditions after ? are not supported")));
    }
    if !KEYWORDS.contains(&keyword) {
        let known = KEYWORDS.join(" ");
        return Err(lines.problem(format!("{keyword:?} is not a supported keyword; there are: {known}")));
    }
    let (steps, duration, every) = increment_header(lines)?;
    let path = path(keyword, lines, unit)?;
    Ok(TestStep { stage: TestStage { path, steps, duration }, output_interval: every, line })
}

/// Reads number of increments, maximum number of iterations and duration (`ninc maxiter deltaTime`), and the output interval after a colon.
fn increment_header(lines: &mut NumberedLines<'_>) -> Result<(usize, f64, usize), TestProblem> {
    let what = "ninc maxiter deltaTime";
    let text = lines.require_line(what)?;
    let (text, every) = text.split_once(':').unwrap_or((text, "1"));
    let [increments, _, time] = lines.numbers_of(text, what)?;
    let increments = lines.integer(increments, what)?;
    let what = "the number after the colon";
    let [every] = lines.numbers_of(every, what)?;
    let every = lines.integer(every, what)?.clamp(1, increments.max(1));
    if increments == 0 {
        return Err(lines.problem("ninc: 0 is not positive"));
    }
    if !(time > 0.0) {
        return Err(lines.problem(format!("deltaTime: {time} is not positive")));
    }
    Ok((increments, time, every))
}

/// Loading path of a keyword, read from the lines that follow it; `unit` is the stress unit of the file (Pa).
fn path(keyword: &str, lines: &mut NumberedLines<'_>, unit: f64) -> Result<LoadingPath, TestProblem> {
    let mut load = LoadRows::zero_strain(StressVariables::Cartesian);
    match keyword {
        "*LinearLoad" => {
            load.variables = variables(lines)?;
            for row in 0..6 {
                let [stress, amount] = lines.numbers("ifstress and an amount")?;
                load.stress[row] = parse_flag(lines, stress)?;
                load.increment[row] = amount;
            }
        }
        "*CirculatingLoad" => {
            load.variables = variables(lines)?;
            for row in 0..6 {
                let what = "ifstress, an amplitude, a phase and an amount";
                let [stress, amplitude, phase, amount] = lines.numbers(what)?;
                load.stress[row] = parse_flag(lines, stress)?;
                (load.amplitude[row], load.phase[row], load.increment[row]) = (amplitude, phase, amount);
            }
        }
        "*DeformationGradient" => return deformation(lines),
        "*OedometricE1" => load.increment[0] = next_number(lines)?,
        "*OedometricS1" => (load.stress[0], load.increment[0]) = (true, next_number(lines)?),
        "*TriaxialE1" => {
            load.increment[0] = next_number(lines)?;
            load.stress[1..3].fill(true);
        }
        "*TriaxialS1" => {
            load.increment[0] = next_number(lines)?;
            load.stress[..3].fill(true);
        }
        "*TriaxialUEq" => {
            load.variables = StressVariables::Roscoe;
            load.increment[1] = next_number(lines)?;
        }
        "*TriaxialUq" => {
            load.variables = StressVariables::Roscoe;
            (load.stress[1], load.increment[1]) = (true, next_number(lines)?);
        }
        "*UndrainedCreep" => {
            load.variables = StressVariables::Roscoe;
            load.stress[1..].fill(true);
        }
        "*PureCreep" => return Ok(LoadingPath::Creep {}),
        _ => return Ok(LoadingPath::Relaxation {}),
    }
    Ok(load.path(unit))
}

/// Single number on the next line.
fn next_number(lines: &mut NumberedLines<'_>) -> Result<f64, TestProblem> {
    lines.numbers("an amount").map(|[value]| value)
}

/// Value of an `ifstress` flag: true for a prescribed stress (1), false for a prescribed strain (0).
fn parse_flag(lines: &NumberedLines<'_>, value: f64) -> Result<bool, TestProblem> {
    if value == 0.0 || value == 1.0 {
        Ok(value == 1.0)
    } else {
        Err(lines.problem(format!("ifstress: {value} is neither 0 (strain) nor 1 (stress)")))
    }
}

/// Loading path to a prescribed deformation gradient, with the nine components in the order of Abaqus.
fn deformation(lines: &mut NumberedLines<'_>) -> Result<LoadingPath, TestProblem> {
    let mut f = [[0.0; 3]; 3];
    // The order of Abaqus: 11 22 33 12 21 13 31 23 32.
    for (i, j) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 0), (0, 2), (2, 0), (1, 2), (2, 1)] {
        let [value] = lines.numbers("a component of the deformation gradient")?;
        f[i][j] = value;
    }
    Ok(LoadingPath::DeformationGradient { deformation: f })
}

/// Variables in which a load prescribes stress and strain.
#[derive(Clone, Copy)]
enum StressVariables {
    /// Cartesian components.
    Cartesian,
    /// Roscoe's `p = -tr T/3`, `q = -T11 + (T22 + T33)/2`, `z = T33 - T22`, and the work-conjugate strains.
    Roscoe,
    /// Roscoe's variables normalised to an orthogonal transformation.
    RoscoeIsomorph,
    /// Rendulic's `-T11`, `-(T22 + T33)/√2`, `(T33 - T22)/√2`.
    Rendulic,
}

/// Stress and strain variables that the next line selects.
fn variables(lines: &mut NumberedLines<'_>) -> Result<StressVariables, TestProblem> {
    let word = lines.require_line("*Cartesian, *Roscoe, *RoscoeIsomorph or *Rendulic")?;
    match word.split_whitespace().next().unwrap_or_default().to_lowercase().as_str() {
        "*cartesian" => Ok(StressVariables::Cartesian),
        "*roscoe" => Ok(StressVariables::Roscoe),
        "*roscoeisomorph" => Ok(StressVariables::RoscoeIsomorph),
        "*rendulic" => Ok(StressVariables::Rendulic),
        _ => {
            Err(lines
                .problem(format!("{word:?} is not one of *Cartesian, *Roscoe, *RoscoeIsomorph, *Rendulic")))
        }
    }
}

impl StressVariables {
    /// Matrices of the stress variables from T11 T22 T33 and of the strain variables from ε11 ε22 ε33.
    fn rows(self) -> ([[f64; 3]; 3], [[f64; 3]; 3]) {
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let (third, s, r3, r6) = (1.0 / 3.0, FRAC_1_SQRT_2, 1.0 / 3f64.sqrt(), 1.0 / 6f64.sqrt());
        match self {
            Self::Cartesian => (unit, unit),
            Self::Roscoe => (
                [[-third; 3], [-1.0, 0.5, 0.5], [0.0, -1.0, 1.0]],
                [[-1.0; 3], [-2.0 * third, third, third], [0.0, -0.5, 0.5]],
            ),
            Self::RoscoeIsomorph => {
                let rows = [[-r3; 3], [-2.0 * r6, r6, r6], [0.0, -s, s]];
                (rows, rows)
            }
            Self::Rendulic => {
                let rows = [[-1.0, 0.0, 0.0], [0.0, -s, -s], [0.0, -s, s]];
                (rows, rows)
            }
        }
    }
}

/// Six equations of a load, each with a prescribed stress or strain.
struct LoadRows {
    variables: StressVariables,
    stress: [bool; 6],
    increment: [f64; 6],
    amplitude: [f64; 6],
    phase: [f64; 6],
}

impl LoadRows {
    /// Equations that prescribe zero strain in all components.
    fn zero_strain(variables: StressVariables) -> Self {
        Self { variables, stress: [false; 6], increment: [0.0; 6], amplitude: [0.0; 6], phase: [0.0; 6] }
    }

    /// Loading path of the six rows, with stresses multiplied by `unit` (Pa) and shear components in the order xy, yz, zx.
    fn path(&self, unit: f64) -> LoadingPath {
        let (of_stress, of_strain) = self.variables.rows();
        let (mut stress, mut strain) = ([[0.0; 6]; 6], [[0.0; 6]; 6]);
        for row in 0..3 {
            let (rows, from) =
                if self.stress[row] { (&mut stress, of_stress) } else { (&mut strain, of_strain) };
            rows[row][..3].copy_from_slice(&from[row]);
        }
        // The files' shear is 12 13 23, this crate's xy yz zx; the files use engineering strain.
        for (row, column) in [(3, 3), (4, 5), (5, 4)] {
            if self.stress[row] {
                stress[row][column] = 1.0;
            } else {
                strain[row][column] = 2.0;
            }
        }
        let scaled = |values: [f64; 6]| {
            std::array::from_fn(|row| if self.stress[row] { values[row] * unit } else { values[row] })
        };
        LoadingPath::General {
            stress,
            strain,
            total: scaled(self.increment),
            amplitude: scaled(self.amplitude),
            phase: self.phase.map(|phase| phase * 180.0 / PI),
            spin: [0.0; 3],
            fluid_stiffness: None,
        }
    }
}
