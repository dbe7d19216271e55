//! Functions of the number of dimensions that are compiled once.

use std::any::Any;

/// A value as one of another type that is the same type. Where the number of dimensions has been told by a `match`, the compiler still takes
/// `Place<D>` and `Place<2>` for two types.
///
/// # Panics
/// When the two are not one type.
pub fn same<T: Any, U: Any>(value: T) -> U {
    let mut value = Some(value);
    let held: &mut dyn Any = &mut value;
    let taken = held.downcast_mut::<Option<U>>().and_then(Option::take);
    taken.unwrap_or_else(|| panic!("{} is not {}", std::any::type_name::<T>(), std::any::type_name::<U>()))
}

/// Calls a function that is generic over the number of dimensions `D` (1, 2 or 3) and compiles it where this stands, once for each: a crate
/// that asks for it compiles nothing of it again. The arguments are variables whose types do not name `D`; `Out<D>` is what the function
/// returns, by the name of a type or an alias.
///
/// ```
/// use colluvium_parallel::once_per_dimension;
///
/// type Corner<const D: usize> = [f64; D];
///
/// fn lowest<const D: usize>(places: &[f64]) -> Corner<D> {
///     std::array::from_fn(|c| places.iter().skip(c).step_by(D).fold(f64::INFINITY, |low, x| low.min(*x)))
/// }
///
/// pub fn corner<const D: usize>(places: &[[f64; D]]) -> [f64; D] {
///     let places = places.as_flattened();
///     once_per_dimension!(D, lowest(places: &[f64]) -> Corner)
/// }
///
/// assert_eq!(corner(&[[1.0, 4.0], [3.0, 2.0]]), [1.0, 2.0]);
/// ```
#[macro_export]
macro_rules! once_per_dimension {
    ($dimension:ident, $function:ident($($argument:ident: $type:ty),*) -> $out:ident) => {{
        #[inline(never)]
        fn on_line($($argument: $type),*) -> $out<1> {
            $function::<1>($($argument),*)
        }
        #[inline(never)]
        fn in_plane($($argument: $type),*) -> $out<2> {
            $function::<2>($($argument),*)
        }
        #[inline(never)]
        fn in_space($($argument: $type),*) -> $out<3> {
            $function::<3>($($argument),*)
        }
        match $dimension {
            1 => $crate::same(on_line($($argument),*)),
            2 => $crate::same(in_plane($($argument),*)),
            3 => $crate::same(in_space($($argument),*)),
            _ => unreachable!("spaces have one to three dimensions"),
        }
    }};
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_handed_on_as_its_own_type_only() {
        assert_eq!(same::<Vec<[f64; 2]>, Vec<[f64; 2]>>(vec![[1.0, 2.0]]), [[1.0, 2.0]]);
        assert!(std::panic::catch_unwind(|| same::<[f64; 2], [f64; 3]>([0.0; 2])).is_err());
    }
}
