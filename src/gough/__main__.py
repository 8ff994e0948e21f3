"""python -m gough"""

from .cli import main

main()
