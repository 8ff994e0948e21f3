"""Control laws, one a file: what force now?"""
