from .regress import estimate
