//! Serde helpers for large nested arrays in a saved state.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_big_array::Array;

/// Array of large arrays.
pub(crate) mod nested {
    use super::*;

    pub(crate) fn serialize<S, T, const M: usize, const N: usize>(
        arrays: &[[T; M]; N],
        serializer: S,
    ) -> Result<S::Ok, S::Error>
    where
        S: Serializer,
        T: Copy + Serialize,
        [Array<T, M>; N]: Serialize,
    {
        arrays.map(Array).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D, T, const M: usize, const N: usize>(
        deserializer: D,
    ) -> Result<[[T; M]; N], D::Error>
    where
        D: Deserializer<'de>,
        [Array<T, M>; N]: Deserialize<'de>,
    {
        Ok(<[Array<T, M>; N]>::deserialize(deserializer)?.map(|array| array.0))
    }
}
