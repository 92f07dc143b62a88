//! Values of iceoryx2 whose code is compiled in this crate only.
//!
//! A program compiles the destructor of each value that it drops, including the generic code of
//! iceoryx2 behind it. Behind a trait object, that code is compiled once, here.

use std::fmt;

/// Access to a value whose destructor other crates do not compile.
pub(crate) trait Holder<T> {
    fn get(&self) -> &T;
}

impl<T> Holder<T> for T {
    fn get(&self) -> &T {
        self
    }
}

/// Box of a value, with its destructor compiled where [`Opaque::new`] is called.
pub(crate) struct Opaque<T>(Box<dyn Holder<T>>);

impl<T: 'static> Opaque<T> {
    pub(crate) fn new(value: T) -> Self {
        Self(Box::new(value))
    }
}

impl<T> std::ops::Deref for Opaque<T> {
    type Target = T;

    fn deref(&self) -> &T {
        (*self.0).get()
    }
}

impl<T: fmt::Debug> fmt::Debug for Opaque<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}
