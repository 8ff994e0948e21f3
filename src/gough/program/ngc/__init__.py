"""NC programs in the language of LinuxCNC (RS274/NGC) to blocks.

lexer -> flow -> interpreter: a text becomes lines, the lines that are executed become words, the words become blocks.
"""
