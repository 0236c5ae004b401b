"""Foreign files: files of other programs that a scene names, read within bounds.

A scene may come from anybody, and so may the files that it names: a SoundFont, a panorama, a
picture or a mesh. `safe_file` opens regular files alone and bounds their size. Compiled libraries
trust what they read, so `reader_process` runs them in a child process with limits of memory and
time: a file that crashes its reader is an error like any other. `verdict_store` remembers which
contents have been found right.

Like `atomic_file` this package is open to everything, `render` and `audio` included, and imports
nothing else of the project.
"""
