"""Films made by many machines: a store that all of them reach, tasks, and engines that run them."""
