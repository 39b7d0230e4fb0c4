"""How kernels are compiled, and the numerical methods that they share.

- `jit`, `by_address`: the decorator that compiles, and calls of kernels by their address
- `compiler`: how Numba compiles here, without work that only other programs need
- `interpreted`: kernels that run as Python source until compiling pays
- `records`: records whose fields are attributes, compiled and in Python
- `known`: numbers that are part of their type, so that kernels do without what they rule out
- `by_type`: kernels that belong to the class of a named tuple
- `altered`, `held`: named tuples with some fields changed, and handed on by address, in kernels
- `roots`, `search`: zeros and greatest values, one step in a kernel, and of many functions at once
- `gauss`: nodes of Gauss and a block of them
- `chebyshev`: functions as Chebyshev series
"""
