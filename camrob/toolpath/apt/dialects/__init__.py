"""The dialects of CL text, one file each; `registry` lists them."""
