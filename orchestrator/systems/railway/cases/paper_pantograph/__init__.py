"""The paper of Kaniewski and Cichoński (2019), claim by claim: a lumped catenary through the table of EN 50318."""
