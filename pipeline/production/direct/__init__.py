"""Direct: a simulation that another program steps, queries and commands, by JSON-RPC."""
