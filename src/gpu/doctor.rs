//! Is this adapter fit to be trusted?
