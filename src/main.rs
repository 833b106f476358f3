//! The program: everything is in the library, but for what it says where memory runs out.

use std::alloc::{GlobalAlloc, Layout, System};

/// The system's memory. Where it has none left, the language ends a program by a signal and names no remedy.
struct Telling;

#[global_allocator]
static MEMORY: Telling = Telling;

/// Whoever asks for more at once may have another way without, as readers of images do.
const LARGE: usize = 1 << 28;

/// Passes memory on; where there is none, says so and ends the program.
fn given(memory: *mut u8, size: usize) -> *mut u8 {
    if memory.is_null() && size < LARGE {
        // No text is made of numbers here: that would take memory.
        eprintln!(
            "lumenwalk: the system has no memory left for this process; close other programs, raise its limit (ulimit -v, \
             that of a container), or ask for fewer patches and smaller pictures"
        );
        std::process::exit(1);
    }
    memory
}

// SAFETY: every call is the system allocator's own, with the arguments that came; what it gives is handed on unchanged.
#[allow(unsafe_code, reason = "there is no other way to a word where memory runs out")]
unsafe impl GlobalAlloc for Telling {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        given(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        given(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        given(unsafe { System.realloc(memory, layout, size) }, size)
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { System.dealloc(memory, layout) };
    }
}

fn main() -> std::process::ExitCode {
    lumenwalk::cli::run()
}
