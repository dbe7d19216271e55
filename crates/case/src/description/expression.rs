//! Parsed text of a formula of the coordinates.

/// Names of the coordinates in a formula.
pub(super) const COORDINATES: [&str; 3] = ["x", "y", "z"];

#[cfg(feature = "formulas")]
pub(super) use parsed::Expression;
#[cfg(not(feature = "formulas"))]
pub(super) use without_parser::Expression;

/// Expressions that are parsed by `exmex`.
#[cfg(feature = "formulas")]
mod parsed {
    use exmex::{Express, FlatEx, FloatOpsFactory, MatchLiteral};

    use super::COORDINATES;

    /// Largest length of a formula (bytes), since its parser is recursive.
    const MAX_LENGTH: usize = 4000;
    /// Largest depth of brackets, since its parser is recursive.
    const MAX_DEPTH: usize = 100;

    /// Expression of the coordinates.
    #[derive(Clone, Debug)]
    pub(in crate::description) struct Expression {
        tree: Tree,
        /// Axes of its variables, in the order of its arguments.
        axes: Vec<usize>,
    }

    /// Parsed expression of the formula.
    type Tree = FlatEx<f64, FloatOpsFactory<f64>, JsonNumbers>;

    /// Number format of JSON, `2.5e-3`: the parser's own has no exponents.
    #[derive(Clone, Debug, Default)]
    struct JsonNumbers;

    impl MatchLiteral for JsonNumbers {
        fn is_literal(text: &str) -> Option<&str> {
            let digits = |from: usize| text[from..].bytes().take_while(u8::is_ascii_digit).count();
            let whole = digits(0);
            let dot = usize::from(text[whole..].starts_with('.'));
            let part = if dot == 1 { digits(whole + 1) } else { 0 };
            if whole + part == 0 {
                return None;
            }
            let end = whole + dot + part;
            let exponent = text[end..].strip_prefix(['e', 'E']).map_or(0, |rest| {
                let sign = usize::from(rest.starts_with(['+', '-']));
                let size = digits(end + 1 + sign);
                if size == 0 { 0 } else { 1 + sign + size }
            });
            Some(&text[..end + exponent])
        }
    }

    impl Expression {
        /// Parses a text; the error says why it is no formula.
        pub(in crate::description) fn parse(words: &str) -> Result<Self, String> {
            if !words.is_ascii() {
                return Err(format!(
                    "{words:?} is not a formula: it has characters other than plain letters, digits and signs"
                ));
            }
            let depth = words.bytes().scan(0usize, |open, byte| {
                *open = match byte {
                    b'(' => *open + 1,
                    b')' => open.saturating_sub(1),
                    _ => *open,
                };
                Some(*open)
            });
            if words.len() > MAX_LENGTH || depth.max().unwrap_or(0) > MAX_DEPTH {
                return Err(format!(
                    "a formula has at most {MAX_LENGTH} characters and {MAX_DEPTH} nested brackets"
                ));
            }
            let tree = Tree::parse(words).map_err(|error| format!("{words:?} is not a formula: {error}"))?;
            let axis = |name: &String| {
                COORDINATES.iter().position(|coordinate| coordinate == name).ok_or_else(|| {
                    format!(
                        "{name:?} in {words:?} is neither a coordinate (x, y, z) nor a function with its bracket"
                    )
                })
            };
            let axes = tree.var_names().iter().map(axis).collect::<Result<_, _>>()?;
            Ok(Self { tree, axes })
        }

        /// Value at `x` (m); not finite where it is undefined.
        pub(in crate::description) fn evaluate(&self, x: [f64; 3]) -> f64 {
            let mut values = [0.0; 3];
            for (value, axis) in values.iter_mut().zip(&self.axes) {
                *value = x[*axis];
            }
            self.tree.eval(&values[..self.axes.len()]).unwrap_or(f64::NAN)
        }

        /// Axes of its coordinates.
        pub(in crate::description) fn axes(&self) -> &[usize] {
            &self.axes
        }
    }
}

/// Replacement in a build without the parser: every text is refused.
#[cfg(not(feature = "formulas"))]
mod without_parser {
    /// Expression of the coordinates; there is none.
    #[derive(Clone, Debug)]
    pub(in crate::description) enum Expression {}

    impl Expression {
        pub(in crate::description) fn parse(words: &str) -> Result<Self, String> {
            Err(CaseErrorKind::coded(
                "formula",
                format!(
                    "{words:?} is a formula, which needs the feature `formulas` of the crate colluvium-case"
                ),
            ))
        }

        pub(in crate::description) fn evaluate(&self, _x: [f64; 3]) -> f64 {
            match *self {}
        }

        pub(in crate::description) fn axes(&self) -> &[usize] {
            match *self {}
        }
    }
}
