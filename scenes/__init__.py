"""What an apartment is; reference apartments; the generator."""
