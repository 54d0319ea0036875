//! Checks what types cannot say.
