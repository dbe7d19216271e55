//! Input of A. Niemunis' incrementalDriver: `parameters.inp`, `initialconditions.inp`, `test.inp`.
//!
//! Stress and strain are tension-positive, components 11 22 33 12 13 23 with engineering shear; axis 1
//! is x. A step of `test.inp` becomes a [`TestStage`] with equal equations; `maxiter` is read and
//! ignored. The law is not part of the files: it is given separately.

mod test_steps;

use super::{DriverError, ElementPath, ElementTest, TestProblem, TestStage};
use crate::MaterialSpec;
use crate::laws::UmatSpec;

/// Input of the program incrementalDriver: texts of its three files, and data that are not in them.
#[derive(Clone, Debug)]
pub struct IncrementalInput<'t> {
    /// Text of `parameters.inp`, if present.
    pub parameters: Option<&'t str>,
    /// Text of `initialconditions.inp`.
    pub initial: &'t str,
    /// Text of `test.inp`.
    pub test: &'t str,
    /// Material law.
    pub material: MaterialSpec,
    /// Unit of stress in the files (Pa), for example 1000 for kPa.
    pub stress_unit: f64,
}

/// Properties of a user material from `parameters.inp`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UmatProperties {
    /// Name of the material.
    pub name: String,
    /// Values of the material properties, in the order of the file.
    pub values: Vec<f64>,
}

/// Element test that is described by the files of incrementalDriver.
#[derive(Clone, Debug, PartialEq)]
pub struct IncrementalTest {
    /// Element test with its material and stages.
    pub test: ElementTest,
    /// Output interval of each stage: every n-th row is written.
    pub output_interval: Vec<usize>,
    /// State variables of `initialconditions.inp`, for laws that use them.
    pub state: Vec<f64>,
    /// Properties of `parameters.inp`, for laws that use them.
    pub parameters: UmatProperties,
    /// Whether the law uses the properties and the state variables of the files; only a user material without its own values does.
    pub uses_file_values: [bool; 2],
}

/// Largest number of state variables of a user material.
const MAX_STATE_VARIABLES: usize = 100_000;

/// Name of the file of properties.
pub const PARAMETERS: &str = "parameters.inp";
/// Name of the file of initial conditions.
pub const INITIAL: &str = "initialconditions.inp";
/// Name of the file of steps.
pub const TEST: &str = "test.inp";

impl IncrementalTest {
    /// Reads the files.
    ///
    /// # Errors
    /// Problems of the input, each with file and line as its path.
    pub fn read(input: &IncrementalInput<'_>) -> Result<Self, Vec<TestProblem>> {
        let parameters = input.parameters.map_or(Ok(UmatProperties::default()), parameters);
        let initial = initial(input.initial, input.stress_unit);
        let steps = test_steps::read_steps(input.test, input.stress_unit);
        let (parameters, (initial_stress, state), steps) = match (parameters, initial, steps) {
            (Ok(parameters), Ok(initial), Ok(steps)) => (parameters, initial, steps),
            (a, b, c) => return Err([a.err(), b.err(), c.err()].into_iter().flatten().collect()),
        };
        let mut material = input.material.clone();
        let takes = match &mut material {
            MaterialSpec::Umat(umat) => fill_from_files(umat, &parameters, &state, input.stress_unit),
            _ => [false; 2],
        };
        let test = ElementTest {
            title: steps.title,
            material,
            initial_stress,
            stages: steps.steps.iter().map(|step| step.stage.clone()).collect(),
        };
        if let Err(DriverError::Invalid(problems)) = test.validate() {
            let lines: Vec<usize> = steps.steps.iter().map(|step| step.line).collect();
            return Err(problems.into_iter().map(|problem| with_file_line(problem, &lines)).collect());
        }
        let every = steps.steps.iter().map(|step| step.output_interval).collect();
        Ok(Self { test, output_interval: every, state, parameters, uses_file_values: takes })
    }

    /// Removes the rows that the output intervals of the stages omit. The last one of every stage is kept.
    pub fn remove_unwanted_rows(&self, path: &mut ElementPath) {
        let mut wanted = vec![true];
        for (TestStage { steps, .. }, every) in self.test.stages.iter().zip(&self.output_interval) {
            wanted.extend((0..*steps).map(|step| step % every == 0 || step + 1 == *steps));
        }
        let last = path.rows.len().wrapping_sub(1);
        let mut row = 0..;
        path.rows.retain(|_| {
            let row = row.next().unwrap_or(last);
            row == last || wanted.get(row).copied().unwrap_or(true)
        });
    }
}

/// Fills missing values of a user material from the files. The results tell whether it uses their properties and state variables.
fn fill_from_files(
    umat: &mut UmatSpec,
    parameters: &UmatProperties,
    state: &[f64],
    stress_unit: f64,
) -> [bool; 2] {
    let takes = [umat.props.is_empty(), umat.state_variables.is_empty()];
    if takes[0] {
        umat.props.clone_from(&parameters.values);
    }
    if takes[1] {
        umat.state_variables = state.to_vec();
    }
    if umat.material_name.is_empty() {
        umat.material_name.clone_from(&parameters.name);
    }
    umat.pascals.get_or_insert(stress_unit);
    takes
}

/// Problem of a test, with the line of the file at which it occurs as its path.
fn with_file_line(problem: TestProblem, lines: &[usize]) -> TestProblem {
    let TestProblem { path, problem } = problem;
    let stage = path.strip_prefix("stages[").and_then(|rest| rest.split(']').next());
    let line = stage.and_then(|number| number.parse().ok()).and_then(|number: usize| lines.get(number));
    let path = match line {
        Some(line) => format!("{TEST}:{line}"),
        None if path.starts_with("stages") => TEST.to_owned(),
        None if path.starts_with("initial_stress") => INITIAL.to_owned(),
        None => path,
    };
    TestProblem { path, problem }
}

/// Non-blank lines of a file, numbered from 1.
struct NumberedLines<'t> {
    file: &'static str,
    lines: std::iter::Enumerate<std::str::Lines<'t>>,
    /// Number of the line read last.
    number: usize,
}

impl<'t> NumberedLines<'t> {
    /// Reader of a text at its first line; `file` is the name in messages.
    fn new(file: &'static str, text: &'t str) -> Self {
        Self { file, lines: text.lines().enumerate(), number: 0 }
    }

    /// Next line that is not blank.
    fn next_line(&mut self) -> Option<&'t str> {
        for (index, line) in self.lines.by_ref() {
            self.number = index + 1;
            if !line.trim().is_empty() {
                return Some(line.trim());
            }
        }
        None
    }

    /// Problem at the current line of the file.
    fn problem(&self, problem: impl Into<String>) -> TestProblem {
        TestProblem { path: format!("{}:{}", self.file, self.number), problem: problem.into() }
    }

    /// Next line, or the problem that the file ends where `what` is expected.
    fn require_line(&mut self, what: &str) -> Result<&'t str, TestProblem> {
        match self.next_line() {
            Some(line) => Ok(line),
            None => Err(self.problem(format!("the file ends where {what} is expected"))),
        }
    }

    /// First `N` numbers of the next line; the remaining text is a comment.
    fn numbers<const N: usize>(&mut self, what: &str) -> Result<[f64; N], TestProblem> {
        let line = self.require_line(what)?;
        self.numbers_of(line, what)
    }

    /// The `N` numbers of a line, separated by blanks; `what` describes them in the message of a failure.
    fn numbers_of<const N: usize>(&self, line: &str, what: &str) -> Result<[f64; N], TestProblem> {
        let mut words =
            line.split_whitespace().map(|word| word.trim_matches(',')).filter(|word| !word.is_empty());
        let mut values = [0.0; N];
        for value in &mut values {
            let word = words.next().unwrap_or_default();
            if has_comma(word) {
                return Err(self.problem(format!(
                    "{word:?} has a comma: write decimals with a point, and blanks between numbers"
                )));
            }
            let word = word.split(',').next().unwrap_or_default();
            *value = number(word).ok_or_else(|| self.problem(format!("{line:?} is not {what}")))?;
        }
        if words.next().is_some_and(|word| word.starts_with('?')) {
            return Err(self.problem(format!("{line:?}: conditions after ? are not supported")));
        }
        Ok(values)
    }

    /// Number on the next line, which must be a non-negative integer.
    fn count(&mut self, what: &str) -> Result<usize, TestProblem> {
        let [value] = self.numbers(what)?;
        self.integer(value, what)
    }

    /// Converts a number to a count, or returns the problem that it is no non-negative integer.
    fn integer(&self, value: f64, what: &str) -> Result<usize, TestProblem> {
        if value >= 0.0 && value.fract() == 0.0 && value <= f64::from(u32::MAX) {
            Ok(value as usize)
        } else {
            Err(self.problem(format!("{value} is not a count in {what}")))
        }
    }
}

/// Whether a word has a comma between two digits, that is a decimal comma or two numbers without a blank.
fn has_comma(word: &str) -> bool {
    let digit = |c: char| c.is_ascii_digit();
    word.split_once(',').is_some_and(|(head, tail)| head.ends_with(digit) && tail.starts_with(digit))
}

/// Finite number in Fortran's notation, `1.5d-3` included.
fn number(word: &str) -> Option<f64> {
    let value: f64 = word.replace(['d', 'D'], "e").parse().ok()?;
    value.is_finite().then_some(value)
}

/// Name of the material and its properties, read from the text of `parameters.inp`.
fn parameters(text: &str) -> Result<UmatProperties, TestProblem> {
    let mut lines = NumberedLines::new(PARAMETERS, text);
    let name = lines.require_line("the material's name")?;
    let name = name.split('#').next().unwrap_or_default().trim().to_owned();
    let count = lines.count("the number of properties")?;
    let value = |_| lines.numbers("a property").map(|[value]| value);
    Ok(UmatProperties { name, values: (0..count).map(value).collect::<Result<_, _>>()? })
}

/// Initial stress in the order of this crate (Pa), and state variables.
fn initial(text: &str, unit: f64) -> Result<([f64; 6], Vec<f64>), TestProblem> {
    let mut lines = NumberedLines::new(INITIAL, text);
    let count = lines.count("the number of stress components")?;
    if count > 6 {
        return Err(lines.problem(format!("{count} stress components: there are at most 6")));
    }
    let mut stress = [0.0; 6];
    for component in stress.iter_mut().take(count) {
        let [value] = lines.numbers("a stress component")?;
        *component = value * unit;
    }
    let [t11, t22, t33, t12, t13, t23] = stress;
    let stress = [t11, t22, t33, t12, t23, t13];
    let count = lines.count("the number of state variables")?;
    if count > MAX_STATE_VARIABLES {
        return Err(lines.problem(format!("{count} state variables are more than {MAX_STATE_VARIABLES}")));
    }
    let mut state = Vec::new();
    // The file may end early: missing values are zero.
    while state.len() < count
        && let Some(line) = lines.next_line()
    {
        let [value] = lines.numbers_of(line, "a state variable")?;
        state.push(value);
    }
    state.resize(count, 0.0);
    Ok((stress, state))
}
